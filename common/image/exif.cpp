#include "common/image/exif.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace strobe::image {

namespace {

std::optional<std::uint64_t> number(Bytes bytes, std::uint64_t at, unsigned size, bool big_endian) {
  if (at > bytes.size() || size > bytes.size() - at) return std::nullopt;
  std::uint64_t value = 0;
  for (unsigned i = 0; i < size; ++i)
    value = value << 8 | bytes[static_cast<std::size_t>(at) + (big_endian ? i : size - 1 - i)];
  return value;
}

}  // namespace

int exif_orientation(Bytes exif) {
  if (exif.size() < 8) return 1;
  const bool big_endian = exif[0] == 'M';
  const auto directory = number(exif, 4, 4, big_endian);
  const auto entries = number(exif, *directory, 2, big_endian);
  if (!entries) return 1;
  constexpr std::uint64_t kOrientation = 0x0112, kShort = 3;
  for (std::uint64_t i = 0; i < *entries; ++i) {
    const std::uint64_t entry = *directory + 2 + 12 * i;
    const auto tag = number(exif, entry, 2, big_endian);
    if (!tag) return 1;
    if (*tag != kOrientation || number(exif, entry + 2, 2, big_endian) != kShort) continue;
    const auto value = number(exif, entry + 8, 2, big_endian);
    return value && *value >= 1 && *value <= 8 ? static_cast<int>(*value) : 1;
  }
  return 1;
}

}  // namespace strobe::image
