// An LCM message as bytes. Pure; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <vector>

namespace strobe::messages {

template <typename Message>
std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace strobe::messages
