// Unsigned numbers in a file's bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/image/image_files.hpp"

namespace strobe::image {

/// `size` bytes, at most 8, from `at` on. Returns nullopt if one of them lies past the end.
inline std::optional<std::uint64_t> read_number(Bytes bytes, std::uint64_t at, unsigned size,
                                                std::endian order) {
  if (at > bytes.size() || size > bytes.size() - at) return std::nullopt;
  std::uint64_t value = 0;
  for (unsigned i = 0; i < size; ++i) {
    const std::size_t next = order == std::endian::big ? i : size - 1 - i;
    value = value << 8 | bytes[static_cast<std::size_t>(at) + next];
  }
  return value;
}

}  // namespace strobe::image
