// A picture in memory: rows from the top, the numbers of a pixel side by side. Not thread-safe to change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

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

 private:
  int width_ = 0;
  int height_ = 0;
  int channels_ = 1;
  int bits_ = 8;
  std::unique_ptr<std::uint8_t[]> numbers_;
};

}  // namespace strobe::image
