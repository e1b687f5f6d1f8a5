// Numbers as GigE Vision sends them: most significant byte first. Pure; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace strobe::sim::gev {

using Bytes = std::span<const std::uint8_t>;
using Packet = std::vector<std::uint8_t>;

/// The number of `size` bytes (1 to 8) that begins there; the bytes must be there.
inline std::uint64_t number_at(Bytes bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size)) value = (value << 8) | byte;
  return value;
}
inline std::uint32_t word_at(Bytes bytes, std::size_t at) {
  return static_cast<std::uint32_t>(number_at(bytes, at, 4));
}

inline void store(std::span<std::uint8_t> bytes, std::size_t at, std::size_t size, std::uint64_t value) {
  for (std::size_t i = 0; i < size; ++i)
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * (size - 1 - i)));
}

inline void append(Packet& packet, std::size_t size, std::uint64_t value) {
  packet.resize(packet.size() + size);
  store(packet, packet.size() - size, size, value);
}

}  // namespace strobe::sim::gev
