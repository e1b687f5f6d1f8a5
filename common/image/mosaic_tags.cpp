#include "common/image/mosaic_tags.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace strobe::image {

std::optional<Mosaic> read_mosaic_tags(TIFF* tiff) {
  const std::uint16_t* tile = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_CFAREPEATPATTERNDIM, &tile) == 0 || tile[0] != 2 || tile[1] != 2)
    return std::nullopt;
  Mosaic mosaic;
  std::uint16_t count = 0;
  const std::uint8_t* colours = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_CFAPATTERN, &count, &colours) == 0 || count != mosaic.colours.size())
    return std::nullopt;
  std::copy_n(colours, mosaic.colours.size(), mosaic.colours.begin());
  const float* black = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_BLACKLEVEL, &count, &black) == 0 || count != 1 || !(black[0] >= 0) ||
      black[0] > 65535)
    return std::nullopt;
  mosaic.black = static_cast<int>(black[0]);
  const std::uint32_t* white = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_WHITELEVEL, &count, &white) == 0 || count != 1 || white[0] > 65535)
    return std::nullopt;
  mosaic.white = static_cast<int>(white[0]);
  return mosaic.is_valid() ? std::optional(mosaic) : std::nullopt;
}

bool write_mosaic_tags(TIFF* tiff, const Mosaic& mosaic) {
  const std::array<std::uint16_t, 2> tile{2, 2};
  const auto black = static_cast<float>(mosaic.black);
  const auto white = static_cast<std::uint32_t>(mosaic.white);
  return TIFFSetField(tiff, TIFFTAG_CFAREPEATPATTERNDIM, tile.data()) != 0 &&
         TIFFSetField(tiff, TIFFTAG_CFAPATTERN, static_cast<int>(mosaic.colours.size()),
                      mosaic.colours.data()) != 0 &&
         TIFFSetField(tiff, TIFFTAG_BLACKLEVEL, 1, &black) != 0 &&
         TIFFSetField(tiff, TIFFTAG_WHITELEVEL, 1, &white) != 0;
}

}  // namespace strobe::image
