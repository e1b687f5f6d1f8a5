#include "host/digitize/image/image_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <optional>
#include <string>

#include "common/image/checks.hpp"
#include "common/image/numbers.hpp"

namespace strobe::digitize {

namespace {

using image::Bytes;

constexpr std::uint64_t kMissing = ~std::uint64_t{0};

/// Of at most 8 bytes; kMissing past the end.
std::uint64_t number(Bytes bytes, std::uint64_t at, unsigned size, bool big_endian) {
  return image::read_number(bytes, at, size, big_endian ? std::endian::big : std::endian::little)
      .value_or(kMissing);
}

bool starts(Bytes bytes, std::string_view with) {
  return bytes.size() >= with.size() &&
         std::equal(with.begin(), with.end(), bytes.begin(),
                    [](char c, unsigned char b) { return static_cast<unsigned char>(c) == b; });
}

tl::unexpected<Error> cut_short(std::string_view format) {
  return fail(fmt::format("the {} file is cut short", format));
}

Result<ImageHeader> sized(ImageHeader header) {
  if (auto checked = image::check_size(header.format, header.width, header.height); !checked)
    return tl::unexpected(checked.error());
  return header;
}

Result<ImageHeader> read_png(Bytes bytes) {
  const std::uint64_t width = number(bytes, 16, 4, true), height = number(bytes, 20, 4, true);
  const std::uint64_t bits = number(bytes, 24, 1, true), colour = number(bytes, 25, 1, true);
  if (colour == kMissing) return cut_short("PNG");
  // All chunks must be present up to IEND; each is length, type, data, CRC.
  std::uint64_t at = 8;
  while (true) {
    const std::uint64_t length = number(bytes, at, 4, true);
    const std::uint64_t kind = number(bytes, at + 4, 4, true);
    if (length == kMissing || kind == kMissing || number(bytes, at + 8 + length, 4, true) == kMissing)
      return cut_short("PNG");
    if (kind == 0x49454E44) break;  // IEND
    at += 12 + length;
  }
  constexpr std::uint64_t kPalette = 3;  // its bits are the indices', not the colours'
  return sized({"PNG", static_cast<std::int64_t>(width), static_cast<std::int64_t>(height),
                colour == kPalette ? 8 : static_cast<int>(bits), false});
}

/// A TIFF's first image file directory.
class TiffDirectory {
 public:
  TiffDirectory(Bytes bytes, bool big_endian) : bytes_(bytes), big_(big_endian) {
    at_ = number(bytes, 4, 4, big_);
    count_ = number(bytes, at_, 2, big_);
  }
  bool is_complete() const { return count_ != kMissing && at_ + 2 + 12 * count_ <= bytes_.size(); }

  struct Field {
    unsigned size = 0;  ///< of a number in bytes
    std::uint64_t count = 0;
    std::uint64_t at = 0;
  };
  /// Returns nullopt if the tag is missing or its type is not an unsigned integer.
  std::optional<Field> field(unsigned tag) const {
    for (std::uint64_t i = 0; i < count_; ++i) {
      const std::uint64_t entry = at_ + 2 + 12 * i;
      if (number(bytes_, entry, 2, big_) != tag) continue;
      const std::uint64_t type = number(bytes_, entry + 2, 2, big_);
      const unsigned size = type == 1 ? 1U : type == 3 ? 2U : type == 4 ? 4U : 0U;
      if (size == 0) return std::nullopt;
      const std::uint64_t count = number(bytes_, entry + 4, 4, big_);
      return Field{size, count, count * size <= 4 ? entry + 8 : number(bytes_, entry + 8, 4, big_)};
    }
    return std::nullopt;
  }
  std::uint64_t value(const Field& field, std::uint64_t index) const {
    return number(bytes_, field.at + index * field.size, field.size, big_);
  }
  std::uint64_t value_of(unsigned tag, std::uint64_t if_absent) const {
    const auto found = field(tag);
    return found && found->count > 0 ? value(*found, 0) : if_absent;
  }

 private:
  Bytes bytes_;
  bool big_;
  std::uint64_t at_ = 0;
  std::uint64_t count_ = 0;
};

/// Whether each strip or tile lies within the file.
bool contains_all_strips(Bytes bytes, const TiffDirectory& directory) {
  for (const auto [offsets_tag, sizes_tag] : {std::array{273U, 279U}, std::array{324U, 325U}}) {
    const auto offsets = directory.field(offsets_tag), sizes = directory.field(sizes_tag);
    if (!offsets || !sizes) continue;
    for (std::uint64_t i = 0; i < offsets->count; ++i) {
      const std::uint64_t offset = directory.value(*offsets, i);
      const std::uint64_t size = i < sizes->count ? directory.value(*sizes, i) : kMissing;
      if (offset == kMissing || size == kMissing || offset + size > bytes.size()) return false;
    }
    return offsets->count > 0;
  }
  return false;
}

/// Offset of the pixels if they are grey, uncompressed, upright, and in contiguous strips.
std::optional<std::size_t> raw_pixels(const TiffDirectory& directory, bool big_endian, std::uint64_t width,
                                      std::uint64_t height, std::uint64_t bits) {
  struct Needed {
    unsigned tag;
    std::uint64_t value;
  };
  // Compression, samples per pixel, fill order, orientation.
  for (const Needed& n : {Needed{259, 1}, Needed{277, 1}, Needed{266, 1}, Needed{274, 1}})
    if (directory.value_of(n.tag, 1) != n.value) return std::nullopt;
  const bool as_in_memory =
      bits == 8 || (bits == 16 && big_endian == (std::endian::native == std::endian::big));
  const auto offsets = directory.field(273), sizes = directory.field(279);
  if (!as_in_memory || !offsets || !sizes || directory.value_of(262, 1) > 1) return std::nullopt;
  const std::uint64_t first = directory.value(*offsets, 0);
  std::uint64_t end = first;
  for (std::uint64_t i = 0; i < offsets->count; ++i) {
    if (directory.value(*offsets, i) != end) return std::nullopt;
    end += directory.value(*sizes, i);
  }
  const bool aligned = bits == 8 || first % 2 == 0;
  if (!aligned || width == 0 || (end - first) / width / (bits / 8) < height) return std::nullopt;
  return static_cast<std::size_t>(first);
}

Result<ImageHeader> read_tiff(Bytes bytes) {
  const bool big_endian = starts(bytes, "MM");
  const TiffDirectory directory(bytes, big_endian);
  if (!directory.is_complete()) return cut_short("TIFF");
  const std::uint64_t width = directory.value_of(256, 0), height = directory.value_of(257, 0);
  const std::uint64_t bits = directory.value_of(258, 1);
  const std::uint64_t meaning = directory.value_of(262, 1), kind = directory.value_of(339, 1);
  for (const std::uint64_t value : {width, height, bits, meaning, kind})
    if (value == kMissing) return cut_short("TIFF");
  if (kind != 1)
    return fail("the TIFF's pixels are signed or floating-point numbers: 1, 8 or 16 bits unsigned are read");
  if (!contains_all_strips(bytes, directory)) return cut_short("TIFF");
  constexpr std::uint64_t kZeroIsWhite = 0;
  return sized({"TIFF", static_cast<std::int64_t>(width), static_cast<std::int64_t>(height),
                static_cast<int>(std::min<std::uint64_t>(bits, 64)), meaning == kZeroIsWhite,
                raw_pixels(directory, big_endian, width, height, bits)});
}

/// Whether the end-of-image marker is there; cameras may pad after it.
bool has_jpeg_end(Bytes bytes) {
  std::size_t end = bytes.size();
  while (end > 2 && (bytes[end - 1] == 0x00 || bytes[end - 1] == 0x0A)) --end;
  return end >= 4 && bytes[end - 2] == 0xFF && bytes[end - 1] == 0xD9;
}

Result<ImageHeader> read_jpeg(Bytes bytes) {
  std::uint64_t at = 2;
  while (true) {
    const std::uint64_t marker = number(bytes, at, 2, true), length = number(bytes, at + 2, 2, true);
    if (length == kMissing) return cut_short("JPEG");
    if (marker == 0xFFFF) {  // fill byte
      ++at;
      continue;
    }
    if (marker < 0xFF00 || length < 2) return fail("the JPEG header is damaged");
    const bool is_frame =
        marker >= 0xFFC0 && marker <= 0xFFCF && marker != 0xFFC4 && marker != 0xFFC8 && marker != 0xFFCC;
    if (is_frame) break;
    at += 2 + length;
  }
  const std::uint64_t bits = number(bytes, at + 4, 1, true);
  const std::uint64_t height = number(bytes, at + 5, 2, true), width = number(bytes, at + 7, 2, true);
  if (width == kMissing || !has_jpeg_end(bytes)) return cut_short("JPEG");
  return sized({"JPEG", static_cast<std::int64_t>(width), static_cast<std::int64_t>(height),
                static_cast<int>(bits), false});
}

Result<ImageHeader> read_bmp(Bytes bytes) {
  const std::uint64_t start = number(bytes, 10, 4, false), header = number(bytes, 14, 4, false);
  if (header == kMissing) return cut_short("BMP");
  if (header < 40) return fail("the BMP is of an old kind that is not read");
  const std::uint64_t bits = number(bytes, 28, 2, false), compression = number(bytes, 30, 4, false);
  if (compression == kMissing) return cut_short("BMP");
  const auto width = static_cast<std::int32_t>(number(bytes, 18, 4, false));
  const auto height = static_cast<std::int32_t>(number(bytes, 22, 4, false));
  const std::int64_t rows = height < 0 ? -std::int64_t{height} : height;  // negative: rows from the top
  if (width > 0 && compression == 0) {
    const std::uint64_t row = (static_cast<std::uint64_t>(width) * bits + 31) / 32 * 4;
    if (start + row * static_cast<std::uint64_t>(rows) > bytes.size()) return cut_short("BMP");
  }
  return sized({"BMP", width, rows, 8, false});
}

/// The next number of a PNM header, after white space and comments; advances `at` past it.
std::optional<std::int64_t> pnm_number(Bytes bytes, std::size_t& at) {
  while (at < bytes.size() && (std::isspace(bytes[at]) != 0 || bytes[at] == '#')) {
    if (bytes[at] == '#')
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    else
      ++at;
  }
  std::int64_t value = 0;
  const std::size_t start = at;
  for (; at < bytes.size() && std::isdigit(bytes[at]) != 0; ++at)
    value = std::min<std::int64_t>(10 * value + (bytes[at] - '0'), 1'000'000'000);
  if (at == start) return std::nullopt;
  return value;
}

Result<ImageHeader> read_pnm(Bytes bytes) {
  const char kind = static_cast<char>(bytes[1]);
  const bool bitmap = kind == '1' || kind == '4';
  std::size_t at = 2;
  const auto width = pnm_number(bytes, at), height = pnm_number(bytes, at);
  const auto top = bitmap ? std::optional<std::int64_t>(1) : pnm_number(bytes, at);
  if (!width || !height || !top) return cut_short("PNM");
  if (*top < 1 || *top > 65535) return fail(fmt::format("the PNM header says a largest number of {}", *top));
  const int bits = bitmap ? 1 : *top < 256 ? 8 : 16;
  if (kind >= '4') {
    const std::int64_t numbers = kind == '6' ? 3 * *width : *width;
    const std::int64_t row = (numbers * bits + 7) / 8;
    // Both factors are at most 1e9 · 6: no overflow.
    if (static_cast<std::int64_t>(at) + 1 + row * *height > static_cast<std::int64_t>(bytes.size()))
      return cut_short("PNM");
  }
  return sized({"PNM", *width, *height, bits, false});
}

}  // namespace

Result<ImageHeader> read_image_header(Bytes bytes) {
  if (bytes.empty()) return fail("the file is empty");
  if (starts(bytes, "\x89PNG\r\n\x1a\n")) return read_png(bytes);
  if (starts(bytes, std::string_view("II*\0", 4)) || starts(bytes, std::string_view("MM\0*", 4)))
    return read_tiff(bytes);
  if (starts(bytes, "\xFF\xD8\xFF")) return read_jpeg(bytes);
  if (starts(bytes, "BM")) return read_bmp(bytes);
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return read_pnm(bytes);
  return fail("it is no picture of a kind that is read (TIFF, PNG, JPEG, BMP, PBM, PGM, PPM)");
}

}  // namespace strobe::digitize
