#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "common/image/checks.hpp"
#include "common/image/image_files.hpp"
#include "common/image/mosaic_tags.hpp"
#include "common/image/tiff_memory.hpp"

namespace strobe::image {

namespace {

/// What a directory says of its pixels.
struct Directory {
  std::uint32_t width = 0, height = 0, kind = 0;
  std::uint16_t bits = 1, samples = 1, meaning = PHOTOMETRIC_MINISBLACK;
  std::uint16_t planes = PLANARCONFIG_CONTIG, orientation = ORIENTATION_TOPLEFT;
  std::uint16_t format = SAMPLEFORMAT_UINT, compression = COMPRESSION_NONE;
  std::optional<Mosaic> mosaic;  ///< of one that is read

  std::uint64_t pixels() const { return std::uint64_t{width} * height; }
  bool is_reduced() const { return (kind & FILETYPE_REDUCEDIMAGE) != 0; }
  /// As a sensor gives them: a mosaic of colours, or DNG's LinearRaw.
  bool is_raw() const { return meaning == PHOTOMETRIC_CFA || meaning == 34892; }
  bool is_grey() const { return meaning == PHOTOMETRIC_MINISBLACK || meaning == PHOTOMETRIC_MINISWHITE; }
  bool apart() const { return planes == PLANARCONFIG_SEPARATE; }
  int channels() const { return is_grey() || mosaic ? 1 : 3; }
  /// Whether the numbers are taken as they are. libtiff mixes colours of 8 bits with what is behind them.
  bool is_plain() const {
    if (bits < 8 || bits > 16 || samples < channels()) return false;
    if (bits == 8 && samples > channels()) return false;
    return is_grey() || mosaic || meaning == PHOTOMETRIC_RGB;
  }
};

Directory read_directory(TIFF* tiff) {
  Directory d;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &d.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &d.height);
  TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &d.kind);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &d.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &d.samples);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &d.meaning);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &d.planes);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &d.orientation);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &d.format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &d.compression);
  if (d.meaning == PHOTOMETRIC_CFA && d.bits == 16 && d.samples == 1 && d.compression == COMPRESSION_NONE)
    d.mosaic = read_mosaic_tags(tiff);
  return d;
}

/// The file's pages, those below others (SubIFDs) last.
std::vector<Directory> pages_of(TIFF* tiff) {
  constexpr std::size_t kMaxPages = 32;  // no camera's file has more, a hostile one may have thousands
  std::vector<Directory> pages;
  std::vector<std::uint64_t> below;
  do {
    pages.push_back(read_directory(tiff));
    std::uint16_t count = 0;
    std::uint64_t* offsets = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_SUBIFD, &count, &offsets) != 0)
      below.insert(below.end(), offsets, offsets + count);
  } while (pages.size() < kMaxPages && TIFFReadDirectory(tiff) != 0);
  for (std::size_t i = 0; i < below.size() && pages.size() < kMaxPages; ++i)
    if (TIFFSetSubDirectory(tiff, below[i]) != 0) pages.push_back(read_directory(tiff));
  return pages;
}

/// Of CR2, whose first directory has nothing that tells.
bool has_canon_mark(Bytes bytes) {
  constexpr std::array<unsigned char, 8> kMark{16, 0, 0, 0, 'C', 'R', 2, 0};
  return bytes.size() >= 12 && std::ranges::equal(bytes.subspan(4, 8), kMark);
}

/// RAW files of many cameras are TIFF files whose first page is a thumbnail. A mosaic by itself is none.
bool has_raw_page(TIFF* tiff, const std::vector<Directory>& pages) {
  const void* version = nullptr;
  return std::any_of(pages.begin() + (pages.front().mosaic ? 1 : 0), pages.end(),
                     [](const Directory& page) { return page.is_raw(); }) ||
         (TIFFSetDirectory(tiff, 0) != 0 && TIFFGetField(tiff, TIFFTAG_DNGVERSION, &version) != 0);
}

/// Fails where the first page is not the photograph.
Result<void> check_pages(Bytes bytes) {
  TiffMemory memory{.bytes = bytes, .written = nullptr, .at = 0};
  const OpenTiff tiff = open_tiff(memory);
  if (!tiff) return {};
  const std::vector<Directory> pages = pages_of(tiff.get());
  if (has_canon_mark(bytes) || has_raw_page(tiff.get(), pages))
    return fail("it is a camera's RAW file, of which strobe-raw makes a mosaic TIFF");
  const Directory& first = pages.front();
  for (const Directory& other : pages)
    if (other.pixels() > first.pixels() || (first.is_reduced() && !other.is_reduced()))
      return fail(
          fmt::format("the first page of the TIFF, {} x {} pixels, is a thumbnail of another of {} x {}: "
                      "save that one alone",
                      first.width, first.height, other.width, other.height));
  return {};
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

/// One plane, or all that are together. Returns false if a piece is damaged. `buffer`: for a piece; null:
/// pieces are rows of the raster.
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
      if (buffer == nullptr) {
        if (!read_piece(tiff, piece, number, bytes, raster.row(static_cast<int>(top)))) return false;
        continue;
      }
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
  const bool as_raster =
      !piece->tiles && piece->samples == d.channels() && piece->row_bytes == raster.row_bytes();
  const auto buffer = as_raster ? nullptr : std::make_unique_for_overwrite<std::uint8_t[]>(piece->bytes());
  for (int plane = 0; plane < (d.apart() ? d.channels() : 1); ++plane)
    if (!read_plane(tiff, d, *piece, plane, raster, buffer.get())) return damaged("TIFF", memory.words);
  if (d.meaning == PHOTOMETRIC_MINISWHITE) invert(raster, d.bits);
  raster.mosaic = d.mosaic;
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

/// The first row and column of `stored` are what TIFF 6.0 says of `orientation`, 1 to 8. From 5 on, width and
/// height are exchanged.
Raster turned(const Raster& stored, int orientation) {
  const bool exchanged = orientation >= 5;  // stored rows are columns
  // Whether the first row is at the bottom (right, if exchanged), the first column at the right (bottom).
  const bool last_row_first = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const bool last_column_first = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  Raster shown(exchanged ? stored.height() : stored.width(), exchanged ? stored.width() : stored.height(),
               stored.channels(), stored.bits());
  const std::size_t size = stored.pixel_bytes();
  for (int row = 0; row < stored.height(); ++row) {
    const int down = last_row_first ? stored.height() - 1 - row : row;
    const std::uint8_t* from = stored.row(row);
    for (int column = 0; column < stored.width(); ++column, from += size) {
      const int across = last_column_first ? stored.width() - 1 - column : column;
      std::memcpy(exchanged ? shown.row(across) + size * static_cast<std::size_t>(down)
                            : shown.row(down) + size * static_cast<std::size_t>(across),
                  from, size);
    }
  }
  return shown;
}

bool describe(TIFF* tiff, const Pixels& pixels, const TiffOptions& options, int rows) {
  constexpr int kHorizontalDifferences = 2;
  return TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, pixels.width) != 0 &&
         TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, pixels.height) != 0 &&
         TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, pixels.bits) != 0 &&
         TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, pixels.channels) != 0 &&
         TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                      options.mosaic         ? PHOTOMETRIC_CFA
                      : pixels.channels == 1 ? PHOTOMETRIC_MINISBLACK
                                             : PHOTOMETRIC_RGB) != 0 &&
         TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) != 0 &&
         TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, rows) != 0 &&
         TIFFSetField(tiff, TIFFTAG_COMPRESSION, options.lzw ? COMPRESSION_LZW : COMPRESSION_NONE) != 0 &&
         (!options.lzw || TIFFSetField(tiff, TIFFTAG_PREDICTOR, kHorizontalDifferences) != 0) &&
         (!options.mosaic || write_mosaic_tags(tiff, *options.mosaic));
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

Result<Raster> decode_tiff(Bytes bytes) {
  TiffMemory memory{.bytes = bytes, .written = nullptr, .at = 0};
  const OpenTiff tiff = open_tiff(memory);
  if (!tiff) return damaged("TIFF", memory.words);
  const Directory d = read_directory(tiff.get());
  if (auto checked = check_size("TIFF", d.width, d.height); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_pages(bytes); !checked) return tl::unexpected(checked.error());
  if (d.format != SAMPLEFORMAT_UINT || d.bits > 16)
    return fail(fmt::format("the TIFF's pixels are {} of {} bits: 1 to 16 bits unsigned are read",
                            d.format == SAMPLEFORMAT_UINT ? "numbers" : "signed or floating-point numbers",
                            d.bits));
  if (memory.lost_a_tag || !is_whole(tiff.get(), bytes)) return fail("the TIFF file is cut short");
  auto raster = d.is_plain() ? read_plain(tiff.get(), d, memory) : read_converted(tiff.get(), d, memory);
  if (!raster || d.orientation <= ORIENTATION_TOPLEFT || d.orientation > ORIENTATION_LEFTBOT) return raster;
  if (!d.mosaic) return turned(*raster, d.orientation);
  raster->orientation = d.orientation;
  return raster;
}

bool tiff_is_camera_raw(Bytes bytes) {
  TiffMemory memory{.bytes = bytes, .written = nullptr, .at = 0};
  const OpenTiff tiff = open_tiff(memory);
  return has_canon_mark(bytes) || (tiff && has_raw_page(tiff.get(), pages_of(tiff.get())));
}

Result<std::vector<std::uint8_t>> encode_tiff(const Pixels& pixels, const TiffOptions& options) {
  if (auto checked = check_pixels(pixels); !checked) return tl::unexpected(checked.error());
  if (options.mosaic &&
      (pixels.channels != 1 || pixels.bits != 16 || options.lzw || !options.mosaic->is_valid()))
    return fail("the mosaic cannot be encoded");
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
