// What a picture file says of itself, read without decoding it: so that no file makes the decoder allocate
// more than a photograph needs, and a file that is still being written is told from a broken one. No I/O;
// never throws; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/result.hpp"

namespace strobe::digitize {

struct ImageHeader {
  std::string_view format;  ///< "PNG", "TIFF", "JPEG", "BMP" or "PNM" (PBM, PGM, PPM)
  std::int64_t width = 0;   ///< > 0
  std::int64_t height = 0;  ///< > 0
  int bits = 8;             ///< per number of a pixel
  bool negative = false;    ///< 0 is white, and the decoder leaves it so
  /// Where the file holds its grey pixels, of 8 or of 16 bits, just as this machine's memory would: row by row
  /// from the top, without gaps. Absent: they have to be decoded.
  std::optional<std::size_t> raw_offset = std::nullopt;
};

/// Reads the header of PNG (W3C), TIFF 6.0, JPEG (ITU-T T.81), BMP and PNM files. Fails, without a file's
/// name, for other formats, for headers that are cut short or contradict themselves, for numbers that are no
/// whole numbers, and for files that end before their picture does.
Result<ImageHeader> read_image_header(std::span<const unsigned char> bytes);

}  // namespace strobe::digitize
