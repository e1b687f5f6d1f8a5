#include "common/image/exif.hpp"

#include <bit>
#include <cstdint>

#include "common/image/numbers.hpp"

namespace strobe::image {

int exif_orientation(Bytes exif) {
  if (exif.size() < 8) return 1;
  const std::endian order = exif[0] == 'M' ? std::endian::big : std::endian::little;
  const auto directory = read_number(exif, 4, 4, order);
  const auto entries = read_number(exif, *directory, 2, order);
  if (!entries) return 1;
  constexpr std::uint64_t kOrientation = 0x0112, kShort = 3;
  for (std::uint64_t i = 0; i < *entries; ++i) {
    const std::uint64_t entry = *directory + 2 + 12 * i;
    const auto tag = read_number(exif, entry, 2, order);
    if (!tag) return 1;
    if (*tag != kOrientation || read_number(exif, entry + 2, 2, order) != kShort) continue;
    const auto value = read_number(exif, entry + 8, 2, order);
    return value && *value >= 1 && *value <= 8 ? static_cast<int>(*value) : 1;
  }
  return 1;
}

}  // namespace strobe::image
