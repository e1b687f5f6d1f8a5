#include <array>
#include <optional>

#include "common/image/checks.hpp"
#include "common/image/image_files.hpp"
#include "common/image/numbers.hpp"

namespace strobe::image {

namespace {

using Colour = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// Of at most 4 bytes; 0 past the end.
std::uint32_t number(Bytes bytes, std::uint64_t at, unsigned size) {
  return static_cast<std::uint32_t>(read_number(bytes, at, size, std::endian::little).value_or(0));
}

struct BmpHeader {
  std::uint64_t start = 0, size = 0;
  std::int64_t width = 0, height = 0;
  bool from_the_top = false;
  unsigned bits = 0;
  bool sixteen_green = false;  ///< 6 of 16 bits are green's
  std::uint64_t row_bytes() const { return (static_cast<std::uint64_t>(width) * bits + 31) / 32 * 4; }
};

/// Whether the masks of a file that has its own are ones that are read.
bool read_masks(Bytes bytes, BmpHeader& header) {
  const std::array masks{number(bytes, 54, 4), number(bytes, 58, 4), number(bytes, 62, 4)};
  header.sixteen_green = masks == std::array{0xF800U, 0x07E0U, 0x001FU};
  if (header.bits == 16) return header.sixteen_green || masks == std::array{0x7C00U, 0x03E0U, 0x001FU};
  return header.bits == 32 && masks == std::array{0xFF0000U, 0xFF00U, 0xFFU};
}

Result<BmpHeader> read_bmp_header(Bytes bytes) {
  constexpr std::uint32_t kPlain = 0, kMasks = 3;
  BmpHeader header;
  header.start = number(bytes, 10, 4);
  header.size = number(bytes, 14, 4);
  if (header.size < 40) return fail("the BMP is of an old kind that is not read");
  header.width = static_cast<std::int32_t>(number(bytes, 18, 4));
  const auto height = static_cast<std::int32_t>(number(bytes, 22, 4));
  header.from_the_top = height < 0;
  header.height = height < 0 ? -std::int64_t{height} : height;
  header.bits = number(bytes, 28, 2);
  const std::uint32_t compression = number(bytes, 30, 4);
  if (compression != kPlain && compression != kMasks)
    return fail("the BMP is compressed: only uncompressed ones are read");
  if (compression == kMasks && !read_masks(bytes, header))
    return fail("the BMP's colours are of a kind that is not read");
  const unsigned b = header.bits;
  if (b != 1 && b != 4 && b != 8 && b != 16 && b != 24 && b != 32)
    return fail(fmt::format("the BMP has {} bits a pixel: 1, 4, 8, 16, 24 or 32 are read", b));
  if (auto checked = check_size("BMP", header.width, header.height); !checked)
    return tl::unexpected(checked.error());
  const std::uint64_t end = header.start + header.row_bytes() * static_cast<std::uint64_t>(header.height);
  if (end > bytes.size()) return fail("the BMP file is cut short");
  return header;
}

/// Colours that the file does not list are black.
std::array<Colour, 256> read_palette(Bytes bytes, const BmpHeader& header) {
  std::array<Colour, 256> palette{};
  if (header.bits > 8) return palette;
  const std::uint32_t said = number(bytes, 46, 4), most = 1U << header.bits;
  const std::uint32_t count = said == 0 ? most : std::min(said, most);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t at = 14 + header.size + 4 * std::uint64_t{i};
    for (unsigned c = 0; c < 3; ++c) palette[i][c] = static_cast<std::uint8_t>(number(bytes, at + 2 - c, 1));
  }
  return palette;
}

Colour colour_at(const std::uint8_t* row, std::size_t x, const BmpHeader& header,
                 const std::array<Colour, 256>& palette) {
  if (header.bits <= 8) {
    const std::size_t per_byte = 8 / header.bits;
    const auto shift = static_cast<unsigned>(8 - header.bits * (x % per_byte + 1));
    return palette[row[x / per_byte] >> shift & ((1U << header.bits) - 1U)];
  }
  if (header.bits >= 24) {
    const std::uint8_t* blue = row + x * (header.bits / 8);
    return {blue[2], blue[1], blue[0]};
  }
  const unsigned n = row[2 * x] | static_cast<unsigned>(row[2 * x + 1]) << 8;
  const auto byte = [](unsigned value) { return static_cast<std::uint8_t>(value); };
  if (header.sixteen_green) return {byte(n >> 8 & 0xF8), byte(n >> 3 & 0xFC), byte(n << 3)};
  return {byte(n >> 7 & 0xF8), byte(n >> 2 & 0xF8), byte(n << 3)};
}

}  // namespace

Result<Raster> decode_bmp(Bytes bytes) {
  const auto header = read_bmp_header(bytes);
  if (!header) return tl::unexpected(header.error());
  const auto palette = read_palette(bytes, *header);
  const bool grey = header->bits <= 8 && std::all_of(palette.begin(), palette.end(), [](const Colour& c) {
                      return c[0] == c[1] && c[1] == c[2];
                    });
  Raster raster(static_cast<int>(header->width), static_cast<int>(header->height), grey ? 1 : 3, 8);
  for (int y = 0; y < raster.height(); ++y) {
    const int stored = header->from_the_top ? y : raster.height() - 1 - y;
    const std::uint8_t* from =
        bytes.data() + header->start + header->row_bytes() * static_cast<std::uint64_t>(stored);
    std::uint8_t* to = raster.row(y);
    for (std::size_t x = 0; x < static_cast<std::size_t>(raster.width()); ++x) {
      const Colour colour = colour_at(from, x, *header, palette);
      for (int c = 0; c < raster.channels(); ++c) *to++ = colour[static_cast<std::size_t>(c)];
    }
  }
  return raster;
}

}  // namespace strobe::image
