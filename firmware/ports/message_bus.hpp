// Port: publishes encoded messages to all subscribers. May lose, duplicate or reorder them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace strobe::firmware {

/// Not real-time. May be called while another thread of the process receives.
class MessageBus {
 public:
  virtual ~MessageBus() = default;
  virtual void publish(const std::string& channel, std::span<const std::uint8_t> bytes) = 0;
};

}  // namespace strobe::firmware
