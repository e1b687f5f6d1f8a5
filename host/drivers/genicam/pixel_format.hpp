// How a camera's pixels lie in its frames: the formats of one number a pixel in GenICam's Pixel Format Naming
// Convention (PFNC 2.4, and GigE Vision's older packed ones). Pure; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace strobe::genicam {

enum class Packing {
  whole,   ///< a number in one or two bytes, little-endian
  dense,   ///< the lowest bits first, without gaps ("p")
  paired,  ///< two in three bytes, their low bits together in the middle one ("Packed")
};

struct PixelFormat {
  std::string_view name;
  std::uint32_t code = 0;  ///< PFNC's
  int bits = 8;            ///< of a number, 8 to 16
  Packing packing = Packing::whole;
  std::string_view tile;  ///< of a colour sensor: the first row's two colours, of "RGB"; else empty

  int bits_in_memory() const { return static_cast<int>(code >> 16 & 0xFF); }
  /// 0 red, 1 green, 2 blue: the tile's two rows. Returns nullopt for grey.
  std::optional<std::array<std::uint8_t, 4>> mosaic() const;
};

/// All that are understood, the ones that keep most of the sensor's light first.
std::span<const PixelFormat> pixel_formats();
/// Returns nullptr if it is not understood.
const PixelFormat* find_pixel_format(std::uint32_t code);
const PixelFormat* find_pixel_format(std::string_view name);

/// What a row of so many pixels takes. Returns nullopt where it does not end with a byte.
std::optional<std::size_t> row_bytes(const PixelFormat& format, int width);

/// Numbers that lie in no whole bytes, one row: `numbers` has the row's width.
void unpack_row(const PixelFormat& format, std::span<const std::uint8_t> row,
                std::span<std::uint16_t> numbers);

}  // namespace strobe::genicam
