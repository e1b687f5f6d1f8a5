#include "firmware/publisher/lcm_bus.hpp"

#include <stdexcept>
#include <utility>

#include "common/messages/channels.hpp"

namespace strobe::firmware {

void LcmBus::publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
  lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

void LcmBus::listen(const std::string& channel, Handler handler) {
  handler_ = std::move(handler);
  lcm_.subscribe(channel, &LcmBus::handle, this)->setQueueCapacity(messages::kSubscriptionQueueCapacity);
}

void LcmBus::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (lcm_.handleTimeout(100) < 0) throw std::runtime_error("LCM cannot receive any more");
  }
}

void LcmBus::handle(const lcm::ReceiveBuffer* buffer, const std::string&) {
  handler_(buffer->data, static_cast<int>(buffer->data_size));
}

}  // namespace strobe::firmware
