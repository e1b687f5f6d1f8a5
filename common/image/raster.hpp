// A picture in memory: rows from the top, the numbers of a pixel side by side. Not thread-safe to change.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

namespace strobe::image {

/// Pixels that belong to someone else.
struct Pixels {
  const void* numbers = nullptr;  ///< of 16 bits: in this machine's byte order
  std::size_t row_bytes = 0;      ///< from one row to the next
  int width = 0;                  ///< pixels
  int height = 0;
  int channels = 1;  ///< 1 grey; 3 red, green, blue
  int bits = 8;      ///< of each number: 8 or 16

  const std::uint8_t* row(int y) const {
    return static_cast<const std::uint8_t*>(numbers) + row_bytes * static_cast<std::size_t>(y);
  }
};

/// How a colour sensor's pixels see: each in one colour, in tiles of 2 x 2 (Bayer, US patent 3971065).
struct Mosaic {
  static constexpr std::uint8_t kRed = 0, kGreen = 1, kBlue = 2;
  std::array<std::uint8_t, 4> colours{kRed, kGreen, kGreen, kBlue};  ///< of the tile's two rows
  int black = 0;      ///< the number that a pixel in the dark has, 0 to 65534
  int white = 65535;  ///< that of a full one, black + 1 to 65535

  std::uint8_t colour(int x, int y) const { return colours[static_cast<std::size_t>(y % 2 * 2 + x % 2)]; }
  /// Green twice, on a diagonal, red and blue once; levels in their ranges.
  bool is_valid() const {
    const auto& c = colours;
    const auto diagonal = [&](std::size_t one, std::size_t other, std::size_t red, std::size_t blue) {
      return c[one] == kGreen && c[other] == kGreen && std::min(c[red], c[blue]) == kRed &&
             std::max(c[red], c[blue]) == kBlue;
    };
    return (diagonal(0, 3, 1, 2) || diagonal(1, 2, 0, 3)) && black >= 0 && black < white && white <= 65535;
  }
  bool operator==(const Mosaic&) const = default;
};

/// Pixels of its own, rows without gaps; as Pixels.
class Raster {
 public:
  Raster() = default;
  /// The numbers are not set. Throws bad_alloc.
  Raster(int width, int height, int channels, int bits)
      : width_(width),
        height_(height),
        channels_(channels),
        bits_(bits),
        numbers_(
            std::make_unique_for_overwrite<std::uint8_t[]>(row_bytes() * static_cast<std::size_t>(height))) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  int bits() const { return bits_; }
  std::size_t pixel_bytes() const {
    return static_cast<std::size_t>(channels_) * static_cast<std::size_t>(bits_ / 8);
  }
  std::size_t row_bytes() const { return pixel_bytes() * static_cast<std::size_t>(width_); }
  std::size_t size_bytes() const { return row_bytes() * static_cast<std::size_t>(height_); }
  std::uint8_t* row(int y) { return numbers_.get() + row_bytes() * static_cast<std::size_t>(y); }
  const std::uint8_t* row(int y) const { return numbers_.get() + row_bytes() * static_cast<std::size_t>(y); }
  Pixels pixels() const { return {numbers_.get(), row_bytes(), width_, height_, channels_, bits_}; }

  /// How a viewer would turn the picture for people, by the camera's note on how it was held (EXIF's tag
  /// 0x0112, 1 to 8; 1: not at all). It has not been turned.
  int orientation = 1;

  /// Of one channel of 16 bits: the numbers are a colour sensor's own.
  std::optional<Mosaic> mosaic;

 private:
  int width_ = 0;
  int height_ = 0;
  int channels_ = 1;
  int bits_ = 8;
  std::unique_ptr<std::uint8_t[]> numbers_;
};

}  // namespace strobe::image
