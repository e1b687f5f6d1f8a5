// Image file headers, read before decoding: so that no file makes the decoder allocate more than a photograph
// needs, and a file that is still being written is distinguished from a damaged one. No I/O; never throws;
// thread-safe.
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
  int bits = 8;             ///< per channel
  bool inverted = false;    ///< 0 is white
  /// Offset of uncompressed grey pixels of 8 or 16 bits in this machine's byte order, row by row from the top
  /// without gaps, which need no decoding.
  std::optional<std::size_t> raw_offset = std::nullopt;
};

/// Reads the header of PNG (W3C), TIFF 6.0, JPEG (ITU-T T.81), BMP and PNM files. Fails, without naming the
/// file, for other formats, contradictory or truncated headers, pixels that are not unsigned integers, more
/// than image::kMaxPixels of them, and files that end before their pixels do.
Result<ImageHeader> read_image_header(std::span<const unsigned char> bytes);

}  // namespace strobe::digitize
