#include "firmware/publisher/lcm_bus.hpp"

namespace strobe::firmware {

void LcmBus::publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
  lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

}  // namespace strobe::firmware
