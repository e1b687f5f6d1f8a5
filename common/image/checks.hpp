// What the readers and writers of image files ask alike.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/image/image_files.hpp"

namespace strobe::image {

/// A library's words on one line, of printable characters.
inline std::string one_line(std::string_view words) {
  std::string line(words.substr(0, 200));
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, ' ');
  return line;
}

inline tl::unexpected<Error> damaged(std::string_view format, std::string_view why) {
  return fail(fmt::format("the {} file is damaged ({})", format, one_line(why)));
}

inline Result<void> check_size(std::string_view format, std::int64_t width, std::int64_t height) {
  if (width <= 0 || height <= 0)
    return fail(fmt::format("the {} header says {} x {} pixels", format, width, height));
  // A quotient, as a product of what a header may say overflows.
  if (width > kMaxPixels / height)
    return fail(fmt::format("{} x {} pixels are more than the {} million that are read", width, height,
                            kMaxPixels / 1'000'000));
  return {};
}

inline Result<void> check_pixels(const Pixels& pixels, int max_bits = 16) {
  const bool known =
      (pixels.bits == 8 || pixels.bits == max_bits) && (pixels.channels == 1 || pixels.channels == 3);
  if (pixels.numbers == nullptr || pixels.width <= 0 || pixels.height <= 0 || !known)
    return fail("cannot be encoded");
  return {};
}

bool tiff_is_camera_raw(Bytes tiff);

/// How a camera says that it was held: tag 0x0112 of EXIF (CIPA DC-008), 1 to 8. `exif` begins with the TIFF
/// header, "II" or "MM". Returns 1 if it says nothing that can be read.
int exif_orientation(Bytes exif);

}  // namespace strobe::image
