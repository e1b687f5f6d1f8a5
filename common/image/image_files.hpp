// Image files, read and written in memory: TIFF by libtiff, PNG by libpng, JPEG by libjpeg. All functions: no
// I/O; nothing printed; never throw, whatever the bytes, but for want of memory (bad_alloc); thread-safe; no
// memory is lost on errors. Errors are one line without the file's name.
//
// Pixels are the file's numbers: no colour profile, gamma or scaling is applied; alpha is left out, but that
// libtiff multiplies colours of 8 bits by an unassociated alpha. A brighter pixel has a larger number.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/image/raster.hpp"
#include "common/result.hpp"

namespace strobe::image {

using Bytes = std::span<const unsigned char>;

/// No picture of more pixels is read, so that no file costs more than 6 bytes times these.
inline constexpr std::int64_t kMaxPixels = 120'000'000;

/// TIFF 6.0, the first picture: grey and RGB of 8 to 16 bits, in strips or tiles, planes together or apart,
/// each compression that libtiff knows; whatever else libtiff turns into colours of 8 bits (palette, YCbCr,
/// CMYK, 1 to 4 bits). Numbers of 9 to 15 bits are not scaled to 16. Turned as its tag Orientation says.
/// Fails for a camera's RAW file, and where another page has more pixels: the first one is a thumbnail.
///
/// A colour sensor's mosaic (Raster::mosaic) is read from an uncompressed page of one number of 16 bits, with
/// PhotometricInterpretation 32803, CFARepeatPatternDim 2,2, CFAPattern (TIFF/EP, ISO 12234-2), BlackLevel
/// and WhiteLevel (DNG 1.6); it is not turned.
Result<Raster> decode_tiff(Bytes bytes);

/// PNG (W3C, 2nd edition) of every colour type and depth; 1, 2 and 4 bits and palettes become 8 bits.
Result<Raster> decode_png(Bytes bytes);

/// JPEG (ITU-T T.81) of 8 bits, baseline and progressive: grey, YCbCr, RGB, CMYK. What a decoder would mend
/// by guessing is an error.
Result<Raster> decode_jpeg(Bytes bytes);

/// Whether a camera's own format, which only a library for them reads: by the marks of Canon, Fujifilm,
/// Minolta, Olympus, Panasonic and Sigma, or as a TIFF file with a mosaic in a page (Nikon, Sony, Pentax,
/// DNG).
bool is_camera_raw(Bytes bytes);

/// Any of these, by its first bytes.
Result<Raster> decode(Bytes bytes);

struct TiffOptions {
  bool lzw = false;        ///< compressed, with differences of neighbours
  int rows_per_strip = 0;  ///< 0: all
  std::optional<Mosaic> mosaic =
      std::nullopt;  ///< of one number of 16 bits, uncompressed: what decode_tiff reads
};
Result<std::vector<std::uint8_t>> encode_tiff(const Pixels& pixels, const TiffOptions& options = {});

/// Compressed as quickly as is possible.
Result<std::vector<std::uint8_t>> encode_png(const Pixels& pixels);

/// Of 8 bits; quality from 1 to 100.
Result<std::vector<std::uint8_t>> encode_jpeg(const Pixels& pixels, int quality = 95);

}  // namespace strobe::image
