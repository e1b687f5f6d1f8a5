#include "common/image/image_files.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

#include "common/image/checks.hpp"

namespace strobe::image {

namespace {

/// An unsigned number of `size` bytes, at most 8. Returns nullopt if one of them lies past the end.
std::optional<std::uint64_t> read_number(Bytes bytes, std::uint64_t at, unsigned size, std::endian order) {
  if (at > bytes.size() || size > bytes.size() - at) return std::nullopt;
  std::uint64_t value = 0;
  for (unsigned i = 0; i < size; ++i) {
    const std::size_t next = order == std::endian::big ? i : size - 1 - i;
    value = value << 8 | bytes[static_cast<std::size_t>(at) + next];
  }
  return value;
}

}  // namespace

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

Result<Raster> decode(Bytes bytes) {
  const auto starts = [&](std::string_view with) {
    return bytes.size() >= with.size() &&
           std::ranges::equal(bytes.first(with.size()), with,
                              [](unsigned char b, char c) { return b == static_cast<unsigned char>(c); });
  };
  if (bytes.empty()) return fail("the file is empty");
  if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return decode_tiff(bytes);
  if (starts("\x89PNG\r\n\x1a\n")) return decode_png(bytes);
  if (starts("\xFF\xD8\xFF")) return decode_jpeg(bytes);
  return fail("not a TIFF, PNG or JPEG file");
}

}  // namespace strobe::image
