#include "host/drivers/genicam/pixel_format.hpp"

#include <algorithm>

namespace strobe::genicam {
namespace {

constexpr Packing kWhole = Packing::whole, kDense = Packing::dense, kPaired = Packing::paired;

constexpr std::array kFormats{
    PixelFormat{"Mono16", 0x01100007, 16, kWhole, ""},
    PixelFormat{"Mono14", 0x01100025, 14, kWhole, ""},
    PixelFormat{"Mono12", 0x01100005, 12, kWhole, ""},
    PixelFormat{"Mono10", 0x01100003, 10, kWhole, ""},
    PixelFormat{"BayerGR16", 0x0110002E, 16, kWhole, "GR"},
    PixelFormat{"BayerRG16", 0x0110002F, 16, kWhole, "RG"},
    PixelFormat{"BayerGB16", 0x01100030, 16, kWhole, "GB"},
    PixelFormat{"BayerBG16", 0x01100031, 16, kWhole, "BG"},
    PixelFormat{"BayerGR12", 0x01100010, 12, kWhole, "GR"},
    PixelFormat{"BayerRG12", 0x01100011, 12, kWhole, "RG"},
    PixelFormat{"BayerGB12", 0x01100012, 12, kWhole, "GB"},
    PixelFormat{"BayerBG12", 0x01100013, 12, kWhole, "BG"},
    PixelFormat{"BayerGR10", 0x0110000C, 10, kWhole, "GR"},
    PixelFormat{"BayerRG10", 0x0110000D, 10, kWhole, "RG"},
    PixelFormat{"BayerGB10", 0x0110000E, 10, kWhole, "GB"},
    PixelFormat{"BayerBG10", 0x0110000F, 10, kWhole, "BG"},
    PixelFormat{"Mono12p", 0x010C0047, 12, kDense, ""},
    PixelFormat{"Mono12Packed", 0x010C0006, 12, kPaired, ""},
    PixelFormat{"Mono10p", 0x010A0046, 10, kDense, ""},
    PixelFormat{"Mono10Packed", 0x010C0004, 10, kPaired, ""},
    PixelFormat{"BayerGR12p", 0x010C0057, 12, kDense, "GR"},
    PixelFormat{"BayerRG12p", 0x010C0059, 12, kDense, "RG"},
    PixelFormat{"BayerGB12p", 0x010C0055, 12, kDense, "GB"},
    PixelFormat{"BayerBG12p", 0x010C0053, 12, kDense, "BG"},
    PixelFormat{"BayerGR12Packed", 0x010C002A, 12, kPaired, "GR"},
    PixelFormat{"BayerRG12Packed", 0x010C002B, 12, kPaired, "RG"},
    PixelFormat{"BayerGB12Packed", 0x010C002C, 12, kPaired, "GB"},
    PixelFormat{"BayerBG12Packed", 0x010C002D, 12, kPaired, "BG"},
    PixelFormat{"BayerGR10p", 0x010A0056, 10, kDense, "GR"},
    PixelFormat{"BayerRG10p", 0x010A0058, 10, kDense, "RG"},
    PixelFormat{"BayerGB10p", 0x010A0054, 10, kDense, "GB"},
    PixelFormat{"BayerBG10p", 0x010A0052, 10, kDense, "BG"},
    PixelFormat{"BayerGR10Packed", 0x010C0026, 10, kPaired, "GR"},
    PixelFormat{"BayerRG10Packed", 0x010C0027, 10, kPaired, "RG"},
    PixelFormat{"BayerGB10Packed", 0x010C0028, 10, kPaired, "GB"},
    PixelFormat{"BayerBG10Packed", 0x010C0029, 10, kPaired, "BG"},
    PixelFormat{"Mono8", 0x01080001, 8, kWhole, ""},
    PixelFormat{"BayerGR8", 0x01080008, 8, kWhole, "GR"},
    PixelFormat{"BayerRG8", 0x01080009, 8, kWhole, "RG"},
    PixelFormat{"BayerGB8", 0x0108000A, 8, kWhole, "GB"},
    PixelFormat{"BayerBG8", 0x0108000B, 8, kWhole, "BG"},
};

void unpack_dense(int bits, std::span<const std::uint8_t> row, std::span<std::uint16_t> numbers) {
  std::uint32_t held = 0;
  int held_bits = 0;
  std::size_t at = 0;
  for (std::uint16_t& number : numbers) {
    for (; held_bits < bits && at < row.size(); held_bits += 8)
      held |= static_cast<std::uint32_t>(row[at++]) << held_bits;
    number = static_cast<std::uint16_t>(held & ((1U << bits) - 1U));
    held >>= bits;
    held_bits -= bits;
  }
}

void unpack_paired(int bits, std::span<const std::uint8_t> row, std::span<std::uint16_t> numbers) {
  const int low_bits = bits - 8;
  const unsigned mask = (1U << low_bits) - 1U;
  for (std::size_t pair = 0; 2 * pair < numbers.size() && 3 * pair + 2 < row.size(); ++pair) {
    const unsigned low = row[3 * pair + 1];
    numbers[2 * pair] = static_cast<std::uint16_t>(unsigned{row[3 * pair]} << low_bits | (low & mask));
    if (2 * pair + 1 == numbers.size()) return;
    numbers[2 * pair + 1] =
        static_cast<std::uint16_t>(unsigned{row[3 * pair + 2]} << low_bits | (low >> 4 & mask));
  }
}

}  // namespace

std::optional<std::array<std::uint8_t, 4>> PixelFormat::mosaic() const {
  if (tile.empty()) return std::nullopt;
  const auto colour = [](char letter) {
    return static_cast<std::uint8_t>(std::string_view("RGB").find(letter));
  };
  const std::uint8_t left = colour(tile[0]), right = colour(tile[1]);
  constexpr std::uint8_t kGreen = 1, kSum = 2;  // of red and blue, which lie on a diagonal
  const auto other = [](std::uint8_t c) {
    return c == kGreen ? kGreen : static_cast<std::uint8_t>(kSum - c);
  };
  return std::array<std::uint8_t, 4>{left, right, other(right), other(left)};
}

std::span<const PixelFormat> pixel_formats() { return kFormats; }

const PixelFormat* find_pixel_format(std::uint32_t code) {
  const auto* found = std::ranges::find(kFormats, code, &PixelFormat::code);
  return found == kFormats.end() ? nullptr : found;
}

const PixelFormat* find_pixel_format(std::string_view name) {
  const auto* found = std::ranges::find(kFormats, name, &PixelFormat::name);
  return found == kFormats.end() ? nullptr : found;
}

std::optional<std::size_t> row_bytes(const PixelFormat& format, int width) {
  const auto bits = static_cast<std::size_t>(format.bits_in_memory()) * static_cast<std::size_t>(width);
  if (bits % 8 != 0) return std::nullopt;
  return bits / 8;
}

void unpack_row(const PixelFormat& format, std::span<const std::uint8_t> row,
                std::span<std::uint16_t> numbers) {
  if (format.packing == Packing::dense) return unpack_dense(format.bits, row, numbers);
  if (format.packing == Packing::paired) return unpack_paired(format.bits, row, numbers);
  for (std::size_t x = 0; x < numbers.size() && x < row.size(); ++x) numbers[x] = row[x];  // of 8 bits
}

}  // namespace strobe::genicam
