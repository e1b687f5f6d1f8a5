// Port: commands to this firmware, decoded and well-formed; the interlock decides on them.
#pragma once

#include <cstdint>

#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

/// Values are those of command_t.
enum class CommandKind : std::int8_t { arm = 1, fire, disarm, resend, clear, reset };

struct Command {
  CommandKind kind = CommandKind::arm;
  std::int64_t host_id = 0;
  std::int64_t command_id = 0;
  std::int64_t token = 0;      ///< FIRE: the token it carries
  std::int64_t new_token = 0;  ///< ARM: drawn by the receiver; the host's token if it is armed
  ShotPlan plan;               ///< FIRE
  ShortText host_name;         ///< who asks, for a person; may be empty
  Duration acted_boot_time{};  ///< RESET: CLOCK_BOOTTIME when a person asked for it
  ShortText defect;            ///< why it must be refused; empty if it is valid
};

class CommandSource {
 public:
  virtual ~CommandSource() = default;
  virtual bool pop(Command& command) noexcept = 0;  ///< returns false if there is none; real-time safe
};

}  // namespace strobe::firmware
