#include <bit>
#include <cctype>
#include <cstring>
#include <optional>

#include "common/image/checks.hpp"
#include "common/image/image_files.hpp"

namespace strobe::image {

namespace {

/// Numbers as text, between white space and comments.
class Text {
 public:
  Text(Bytes bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  std::size_t at() const { return at_; }

  /// The next number, of at most so many digits. Returns nullopt at the end and at anything else.
  std::optional<int> next(int most_digits) {
    while (at_ < bytes_.size() && (std::isspace(bytes_[at_]) != 0 || bytes_[at_] == '#')) skip();
    int value = 0, digits = 0;
    for (; digits < most_digits && at_ < bytes_.size() && std::isdigit(bytes_[at_]) != 0; ++digits)
      value = 10 * value + (bytes_[at_++] - '0');
    if (digits == 0) return std::nullopt;
    return value;
  }

 private:
  void skip() {
    if (bytes_[at_] == '#')
      while (at_ < bytes_.size() && bytes_[at_] != '\n' && bytes_[at_] != '\r') ++at_;
    else
      ++at_;
  }
  Bytes bytes_;
  std::size_t at_;
};

constexpr int kDigits = 9;  // of what an int holds

struct PnmHeader {
  int kind = 0;  ///< 1 to 6
  int width = 0, height = 0;
  int top = 1;  ///< the largest number
  std::size_t start = 0;

  bool is_bitmap() const { return kind == 1 || kind == 4; }
  bool is_text() const { return kind <= 3; }
  int channels() const { return kind == 3 || kind == 6 ? 3 : 1; }
  int bits() const { return top > 255 ? 16 : 8; }
};

Result<PnmHeader> read_pnm_header(Bytes bytes) {
  if (bytes.size() < 3) return fail("the PNM file is cut short");
  PnmHeader header;
  header.kind = bytes[1] - '0';
  if (header.kind < 1 || header.kind > 6) return fail("the PNM is of a kind that is not read");
  Text text(bytes, 2);
  const auto width = text.next(kDigits), height = text.next(kDigits);
  const auto top = header.is_bitmap() ? std::optional<int>(1) : text.next(kDigits);
  if (!width || !height || !top) return fail("the PNM file is cut short");
  if (*top < 1 || *top > 65535) return fail(fmt::format("the PNM header says a largest number of {}", *top));
  header.width = *width;
  header.height = *height;
  header.top = *top;
  header.start = text.at();
  if (auto checked = check_size("PNM", *width, *height); !checked) return tl::unexpected(checked.error());
  return header;
}

void put(Raster& raster, int y, std::size_t index, int number) {
  if (raster.bits() == 8) {
    raster.row(y)[index] = static_cast<std::uint8_t>(number);
    return;
  }
  const auto wide = static_cast<std::uint16_t>(number);
  std::memcpy(raster.row(y) + 2 * index, &wide, 2);
}

std::optional<int> next_number(Text& text, const PnmHeader& header) {
  const auto number = text.next(header.is_bitmap() ? 1 : kDigits);
  if (!number) return std::nullopt;
  if (header.is_bitmap()) return *number != 0 ? 0 : 255;  // 1 is black
  const int value = std::min(*number, header.top);
  return header.bits() == 8 ? value * 255 / header.top : value;
}

Result<Raster> read_text(Bytes bytes, const PnmHeader& header) {
  const auto numbers = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.channels());
  // Each number takes a byte or more.
  if (numbers * static_cast<std::size_t>(header.height) > bytes.size())
    return fail("the PNM file is cut short");
  Raster raster(header.width, header.height, header.channels(), header.bits());
  Text text(bytes, header.start);
  for (int y = 0; y < header.height; ++y) {
    for (std::size_t i = 0; i < numbers; ++i) {
      const auto number = next_number(text, header);
      if (!number && text.at() >= bytes.size()) return fail("the PNM file is cut short");
      if (!number) return damaged("PNM", "something that is no number");
      put(raster, y, i, *number);
    }
  }
  return raster;
}

/// One character ends the header.
Result<Raster> read_binary(Bytes bytes, const PnmHeader& header) {
  const auto numbers = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.channels());
  const std::size_t row_bytes =
      header.is_bitmap() ? (numbers + 7) / 8 : numbers * static_cast<std::size_t>(header.bits() / 8);
  const std::size_t start = header.start + 1;
  if (start + row_bytes * static_cast<std::size_t>(header.height) > bytes.size())
    return fail("the PNM file is cut short");
  Raster raster(header.width, header.height, header.channels(), header.bits());
  for (int y = 0; y < header.height; ++y) {
    const unsigned char* from = bytes.data() + start + row_bytes * static_cast<std::size_t>(y);
    if (!header.is_bitmap() && header.bits() == 8) {
      std::memcpy(raster.row(y), from, row_bytes);
      continue;
    }
    for (std::size_t i = 0; i < numbers; ++i)
      put(raster, y, i,
          header.is_bitmap() ? ((from[i / 8] >> (7 - i % 8) & 1) != 0 ? 0 : 255)
                             : from[2 * i] << 8 | from[2 * i + 1]);
  }
  return raster;
}

}  // namespace

Result<Raster> decode_pnm(Bytes bytes) {
  const auto header = read_pnm_header(bytes);
  if (!header) return tl::unexpected(header.error());
  return header->is_text() ? read_text(bytes, *header) : read_binary(bytes, *header);
}

}  // namespace strobe::image
