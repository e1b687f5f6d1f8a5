#include "common/image/checks.hpp"
#include "common/image/tiff_memory.hpp"

namespace strobe::image {

namespace {

bool describe(TIFF* tiff, const Pixels& pixels, const TiffOptions& options, int rows) {
  constexpr int kHorizontalDifferences = 2;
  return TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, pixels.width) != 0 &&
         TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, pixels.height) != 0 &&
         TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, pixels.bits) != 0 &&
         TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, pixels.channels) != 0 &&
         TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                      pixels.channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB) != 0 &&
         TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) != 0 &&
         TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, rows) != 0 &&
         TIFFSetField(tiff, TIFFTAG_COMPRESSION, options.lzw ? COMPRESSION_LZW : COMPRESSION_NONE) != 0 &&
         (!options.lzw || TIFFSetField(tiff, TIFFTAG_PREDICTOR, kHorizontalDifferences) != 0);
}

/// Strip by strip; libtiff may change what it is given, so that it gets a copy.
bool write_strips(TIFF* tiff, const Pixels& pixels, int rows) {
  const std::size_t row_bytes =
      static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.channels * pixels.bits / 8);
  std::vector<std::uint8_t> strip;
  for (int top = 0, number = 0; top < pixels.height; top += rows, ++number) {
    strip.clear();
    for (int y = top; y < std::min(top + rows, pixels.height); ++y)
      strip.insert(strip.end(), pixels.row(y), pixels.row(y) + row_bytes);
    if (TIFFWriteEncodedStrip(tiff, static_cast<std::uint32_t>(number), strip.data(),
                              static_cast<tmsize_t>(strip.size())) < 0)
      return false;
  }
  return true;
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_tiff(const Pixels& pixels, const TiffOptions& options) {
  if (auto checked = check_pixels(pixels); !checked) return tl::unexpected(checked.error());
  std::vector<std::uint8_t> bytes;
  TiffMemory memory{.bytes = {}, .written = &bytes, .at = 0};
  OpenTiff tiff = open_tiff(memory);
  const int rows = options.rows_per_strip > 0 ? options.rows_per_strip : pixels.height;
  if (!tiff || !describe(tiff.get(), pixels, options, rows) || !write_strips(tiff.get(), pixels, rows) ||
      TIFFFlush(tiff.get()) == 0)
    return fail(fmt::format("cannot be encoded ({})", one_line(memory.words)));
  tiff.reset();  // it points at the bytes
  return bytes;
}

}  // namespace strobe::image
