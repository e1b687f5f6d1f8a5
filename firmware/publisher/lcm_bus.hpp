// The message bus over LCM.
#pragma once

#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <stop_token>

#include "firmware/ports/message_bus.hpp"

namespace strobe::firmware {

class LcmBus final : public MessageBus {
 public:
  using Handler = std::function<void(const void* data, int size)>;

  explicit LcmBus(lcm::LCM& lcm) : lcm_(lcm) {}

  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) override;
  /// Once, before run(). The handler runs on run()'s thread and must not throw.
  void listen(const std::string& channel, Handler handler);
  /// Until asked to stop, which takes up to 0.1 s. std::runtime_error: LCM cannot receive any more.
  void run(const std::stop_token& stop);

 private:
  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  lcm::LCM& lcm_;
  Handler handler_;
};

}  // namespace strobe::firmware
