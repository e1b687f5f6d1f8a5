// Publishes over LCM. Commands are received elsewhere (command_feed.hpp).
#pragma once

#include <lcm/lcm-cpp.hpp>

#include "firmware/ports/message_bus.hpp"

namespace strobe::firmware {

class LcmBus final : public MessageBus {
 public:
  explicit LcmBus(lcm::LCM& lcm) : lcm_(lcm) {}

  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) override;

 private:
  lcm::LCM& lcm_;
};

}  // namespace strobe::firmware
