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

bool has(Bytes bytes, std::string_view mark, std::size_t at = 0) {
  return bytes.size() >= at + mark.size() &&
         std::ranges::equal(bytes.subspan(at, mark.size()), mark,
                            [](unsigned char b, char c) { return b == static_cast<unsigned char>(c); });
}

bool is_tiff(Bytes bytes) {
  return has(bytes, std::string_view("II*\0", 4)) || has(bytes, std::string_view("MM\0*", 4));
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

bool is_camera_raw(Bytes bytes) {
  constexpr std::string_view kPanasonic("IIU\0", 4), kMinolta("\0MRM", 4);
  for (const std::string_view mark :
       {kPanasonic, kMinolta, std::string_view("IIRO"), std::string_view("IIRS"), std::string_view("MMOR"),
        std::string_view("FOVb"), std::string_view("FUJIFILMCCD-RAW")})
    if (has(bytes, mark)) return true;
  return has(bytes, "ftypcrx ", 4) || has(bytes, "HEAPCCDR", 6) ||
         (is_tiff(bytes) && tiff_is_camera_raw(bytes));
}

Result<Raster> decode(Bytes bytes) {
  if (bytes.empty()) return fail("the file is empty");
  if (is_tiff(bytes)) return decode_tiff(bytes);
  if (has(bytes, "\x89PNG\r\n\x1a\n")) return decode_png(bytes);
  if (has(bytes, "\xFF\xD8\xFF")) return decode_jpeg(bytes);
  return fail("not a TIFF, PNG or JPEG file");
}

}  // namespace strobe::image
