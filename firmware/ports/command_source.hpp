// Port: commands that were addressed to this firmware, decoded and checked for form; the interlock decides.
#pragma once

#include <cstdint>

#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

enum class CommandKind : std::int8_t {
  arm = 1,
  fire,
  disarm,
  resend,
  clear
};  ///< values are those of command_t

struct Command {
  CommandKind kind = CommandKind::arm;
  std::int64_t host_id = 0;
  std::int64_t command_id = 0;
  std::int64_t token = 0;        ///< FIRE: the token it carries
  std::int64_t fresh_token = 0;  ///< ARM: random, drawn by the receiver; what the host gets if it is armed
  PlanRequest plan;              ///< FIRE
  ShortText defect;              ///< why it must be refused whatever the interlock says; empty: well-formed
};

class CommandSource {
 public:
  virtual ~CommandSource() = default;
  virtual bool pop(Command& command) noexcept = 0;  ///< false: none waits. Real-time safe
};

}  // namespace strobe::firmware
