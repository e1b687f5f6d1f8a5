// Unsigned numbers as bytes, most significant first. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace strobe::authentication {

inline std::uint64_t big_endian(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

inline void put_big_endian(std::span<std::uint8_t> bytes, std::uint64_t value) {
  for (std::size_t i = bytes.size(); i-- > 0; value >>= 8) bytes[i] = static_cast<std::uint8_t>(value);
}

}  // namespace strobe::authentication
