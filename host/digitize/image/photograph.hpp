// A photograph as the digitizer sees it: the light on a grid of pixels. Coordinates on it ("image px"): x the
// column, y the row counted from the top, pixel centres at integers.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "common/result.hpp"

namespace strobe::digitize {

struct Photograph {
  cv::Mat light;  ///< CV_32FC1, proportional to the file's numbers, 1 = the largest that its depth can hold
  int bits = 8;   ///< per number of the file: 1, 8 or 16
  float saturation = 1.0F;  ///< a pixel of this light or more may have had any more light
  std::string name;         ///< the file's, for messages

  int width() const { return light.cols; }
  int height() const { return light.rows; }
};

/// Photographs are from 16 x 16 to this many pixels.
inline constexpr std::int64_t kMaxPixels = 120'000'000;

/// Decodes what OpenCV's imgcodecs reads (TIFF, PNG, JPEG, BMP, PGM ...). Colours become their luminance.
/// Fails with "NAME: what is wrong"; never throws, whatever the bytes. Thread-safe; allocates.
Result<Photograph> decode_photograph(std::span<const unsigned char> bytes, const std::string& name);

/// Reads and decodes a file.
Result<Photograph> load_photograph(const std::filesystem::path& path);

}  // namespace strobe::digitize
