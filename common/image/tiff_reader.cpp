#include <algorithm>
#include <cstring>

#include "common/image/checks.hpp"
#include "common/image/orientation.hpp"
#include "common/image/tiff_memory.hpp"

namespace strobe::image {

namespace {

/// What the first directory says of the pixels.
struct Directory {
  std::uint32_t width = 0, height = 0;
  std::uint16_t bits = 1, samples = 1, meaning = PHOTOMETRIC_MINISBLACK;
  std::uint16_t planes = PLANARCONFIG_CONTIG, orientation = ORIENTATION_TOPLEFT;
  std::uint16_t format = SAMPLEFORMAT_UINT;

  bool is_grey() const { return meaning == PHOTOMETRIC_MINISBLACK || meaning == PHOTOMETRIC_MINISWHITE; }
  bool apart() const { return planes == PLANARCONFIG_SEPARATE; }
  int channels() const { return is_grey() ? 1 : 3; }
  /// Whether the numbers are taken as they are. libtiff mixes colours of 8 bits with what is behind them.
  bool is_plain() const {
    if (bits < 8 || bits > 16 || samples < channels()) return false;
    if (bits == 8 && samples > channels()) return false;
    return is_grey() || meaning == PHOTOMETRIC_RGB;
  }
};

Directory read_directory(TIFF* tiff) {
  Directory d;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &d.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &d.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &d.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &d.samples);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &d.meaning);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &d.planes);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &d.orientation);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &d.format);
  return d;
}

/// A strip or tile.
struct Piece {
  std::uint32_t width = 0, height = 0;
  bool tiles = false;
  int samples = 1;  ///< side by side
  std::size_t row_bytes = 0;
  std::size_t bytes() const { return row_bytes * height; }
};

Result<Piece> piece_of(TIFF* tiff, const Directory& d) {
  Piece piece{.width = d.width,
              .height = d.height,
              .tiles = TIFFIsTiled(tiff) != 0,
              .samples = d.apart() ? 1 : d.samples};
  if (piece.tiles) {
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &piece.width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &piece.height);
  } else {
    std::uint32_t rows = d.height;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
    piece.height = std::min(rows, d.height);
  }
  if (auto checked = check_size("TIFF", piece.width, piece.height); !checked)
    return tl::unexpected(checked.error());
  constexpr int kMaxSamples = 8;
  if (piece.samples > kMaxSamples)
    return fail(fmt::format("a pixel of {} numbers is neither grey nor a colour", d.samples));
  piece.row_bytes = (std::size_t{piece.width} * static_cast<std::size_t>(piece.samples) * d.bits + 7) / 8;
  return piece;
}

template <typename Number>
void copy_whole(const std::uint8_t* from, int samples, int count, int taken, std::uint8_t* to, int channels) {
  for (int x = 0; x < count; ++x)
    for (int c = 0; c < taken; ++c)
      std::memcpy(to + static_cast<std::size_t>(x * channels + c) * sizeof(Number),
                  from + static_cast<std::size_t>(x * samples + c) * sizeof(Number), sizeof(Number));
}

/// Numbers of 9 to 15 bits, packed, the highest bit first.
void copy_packed(const std::uint8_t* from, int bits, int samples, int count, int taken, std::uint8_t* to,
                 int channels) {
  std::uint32_t held = 0;
  int held_bits = 0;
  for (int x = 0; x < count; ++x) {
    for (int s = 0; s < samples; ++s) {
      for (; held_bits < bits; held_bits += 8) held = held << 8 | *from++;
      held_bits -= bits;
      const auto number = static_cast<std::uint16_t>(held >> held_bits & ((1U << bits) - 1U));
      if (s < taken) std::memcpy(to + 2 * static_cast<std::size_t>(x * channels + s), &number, 2);
    }
  }
}

/// The row of a piece to the row of the picture that begins at `to`; the first `taken` numbers of each pixel.
void copy_row(const std::uint8_t* from, const Directory& d, const Piece& piece, int count, int taken,
              std::uint8_t* to) {
  const int channels = d.channels();
  const bool whole = d.bits == 8 || d.bits == 16;
  if (whole && piece.samples == channels && taken == channels)
    std::memcpy(to, from, static_cast<std::size_t>(count * channels) * d.bits / 8);
  else if (d.bits == 8)
    copy_whole<std::uint8_t>(from, piece.samples, count, taken, to, channels);
  else if (d.bits == 16)
    copy_whole<std::uint16_t>(from, piece.samples, count, taken, to, channels);
  else
    copy_packed(from, d.bits, piece.samples, count, taken, to, channels);
}

bool read_piece(TIFF* tiff, const Piece& piece, std::uint32_t number, std::size_t bytes, std::uint8_t* to) {
  const auto size = static_cast<tmsize_t>(bytes);
  const tmsize_t got = piece.tiles ? TIFFReadEncodedTile(tiff, number, to, size)
                                   : TIFFReadEncodedStrip(tiff, number, to, size);
  return got == size;
}

/// One plane, or all that are together. Returns false if a piece is damaged.
bool read_plane(TIFF* tiff, const Directory& d, const Piece& piece, int plane, Raster& raster,
                std::uint8_t* buffer) {
  const auto sample = static_cast<std::uint16_t>(plane);
  const int taken = d.apart() ? 1 : d.channels();
  for (std::uint32_t top = 0; top < d.height; top += piece.height) {
    const std::uint32_t rows = std::min(piece.height, d.height - top);
    for (std::uint32_t left = 0; left < d.width; left += piece.width) {
      const std::uint32_t number =
          piece.tiles ? TIFFComputeTile(tiff, left, top, 0, sample) : TIFFComputeStrip(tiff, top, sample);
      const std::size_t bytes = piece.row_bytes * (piece.tiles ? piece.height : rows);
      if (!read_piece(tiff, piece, number, bytes, buffer)) return false;
      const int count = static_cast<int>(std::min(piece.width, d.width - left));
      for (std::uint32_t y = 0; y < rows; ++y)
        copy_row(buffer + piece.row_bytes * y, d, piece, count, taken,
                 raster.row(static_cast<int>(top + y)) + raster.pixel_bytes() * left +
                     static_cast<std::size_t>(plane * raster.bits() / 8));
    }
  }
  return true;
}

/// So that white has the largest number.
void invert(Raster& raster, int bits) {
  std::uint8_t* byte = raster.row(0);
  if (bits == 8) {
    for (std::size_t i = 0; i < raster.size_bytes(); ++i) byte[i] = static_cast<std::uint8_t>(~byte[i]);
    return;
  }
  const auto top = static_cast<std::uint16_t>((1U << bits) - 1U);
  for (std::size_t i = 0; i < raster.size_bytes(); i += 2) {
    std::uint16_t number = 0;
    std::memcpy(&number, byte + i, 2);
    number = static_cast<std::uint16_t>(top - number);
    std::memcpy(byte + i, &number, 2);
  }
}

Result<Raster> read_plain(TIFF* tiff, const Directory& d, const TiffMemory& memory) {
  const auto piece = piece_of(tiff, d);
  if (!piece) return tl::unexpected(piece.error());
  Raster raster(static_cast<int>(d.width), static_cast<int>(d.height), d.channels(), d.bits == 8 ? 8 : 16);
  const auto buffer = std::make_unique_for_overwrite<std::uint8_t[]>(piece->bytes());
  for (int plane = 0; plane < (d.apart() ? d.channels() : 1); ++plane)
    if (!read_plane(tiff, d, *piece, plane, raster, buffer.get())) return damaged("TIFF", memory.words);
  if (d.meaning == PHOTOMETRIC_MINISWHITE) invert(raster, d.bits);
  return raster;
}

/// By libtiff's own conversion to colours of 8 bits.
Result<Raster> read_converted(TIFF* tiff, const Directory& d, const TiffMemory& memory) {
  char why[1024] = "";
  if (TIFFRGBAImageOK(tiff, why) == 0)
    return fail(fmt::format("the TIFF's pixels are not read ({})", one_line(why)));
  // As stored: turned afterwards, together with the others.
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  constexpr int kStopAtErrors = 1;
  const auto colours = std::make_unique_for_overwrite<std::uint32_t[]>(std::size_t{d.width} * d.height);
  if (TIFFReadRGBAImageOriented(tiff, d.width, d.height, colours.get(), ORIENTATION_TOPLEFT, kStopAtErrors) ==
      0)
    return damaged("TIFF", memory.words);
  Raster raster(static_cast<int>(d.width), static_cast<int>(d.height), d.channels(), 8);
  std::uint8_t* to = raster.row(0);
  for (std::size_t i = 0; i < std::size_t{d.width} * d.height; ++i) {
    *to++ = static_cast<std::uint8_t>(TIFFGetR(colours[i]));
    if (raster.channels() == 1) continue;
    *to++ = static_cast<std::uint8_t>(TIFFGetG(colours[i]));
    *to++ = static_cast<std::uint8_t>(TIFFGetB(colours[i]));
  }
  return raster;
}

/// libtiff goes on without the end of a strip or tile that is cut short.
bool is_whole(TIFF* tiff, Bytes bytes) {
  const std::uint32_t count = TIFFIsTiled(tiff) != 0 ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t offset = TIFFGetStrileOffset(tiff, i), size = TIFFGetStrileByteCount(tiff, i);
    if (offset > bytes.size() || size > bytes.size() - offset) return false;
  }
  return true;
}

}  // namespace

Result<Raster> decode_tiff(Bytes bytes) {
  TiffMemory memory{.bytes = bytes, .written = nullptr, .at = 0};
  const OpenTiff tiff = open_tiff(memory);
  if (!tiff) return damaged("TIFF", memory.words);
  const Directory d = read_directory(tiff.get());
  if (auto checked = check_size("TIFF", d.width, d.height); !checked) return tl::unexpected(checked.error());
  if (d.format != SAMPLEFORMAT_UINT || d.bits > 16)
    return fail(fmt::format("the TIFF's pixels are {} of {} bits: 1 to 16 bits unsigned are read",
                            d.format == SAMPLEFORMAT_UINT ? "numbers" : "signed or floating-point numbers",
                            d.bits));
  if (memory.lost_a_tag || !is_whole(tiff.get(), bytes)) return fail("the TIFF file is cut short");
  auto raster = d.is_plain() ? read_plain(tiff.get(), d, memory) : read_converted(tiff.get(), d, memory);
  if (!raster || d.orientation <= ORIENTATION_TOPLEFT || d.orientation > ORIENTATION_LEFTBOT) return raster;
  return turned(*raster, d.orientation);
}

}  // namespace strobe::image
