// Photographs: decoding, and pixel values on one scale. Image coordinates ("image px"): x is the column, y
// the row counted from the top, pixel centres are at integers.
#pragma once

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "common/result.hpp"

namespace strobe::digitize {

struct Photograph {
  /// CV_32FC1, proportional to the file's numbers; 1 is the largest that they can hold, of a mosaic the white
  /// level, 0 the black level.
  cv::Mat intensity;
  int bits = 8;             ///< that the file's numbers fill, 8 to 16: 12 of 16 are 12
  float saturation = 1.0F;  ///< pixels of this intensity or more are clipped
  std::string name;         ///< the file's, for messages
  /// How EXIF, in a JPEG or PNG, says that the camera was held (1 to 8; 1: upright). The pixels are as
  /// stored: a fixed camera's calibration is of them.
  int orientation = 1;

  /// Of what a file's whole numbers leave of light, in units of intensity: uniform over a step.
  double rounding_sd() const { return 1.0 / (std::sqrt(12.0) * ((1 << bits) - 1)); }

  int width() const { return intensity.cols; }
  int height() const { return intensity.rows; }
};

/// Decodes TIFF, PNG and JPEG (common/image/image_files.hpp), from 16 x 16 to image::kMaxPixels pixels.
/// Colours become luminance, a colour sensor's mosaic its light (mosaic_light.hpp). Fails with "NAME: what is
/// wrong"; never throws, whatever the bytes. Thread-safe; allocates.
Result<Photograph> decode_photograph(std::span<const unsigned char> bytes, const std::string& name);

/// Reads and decodes a file; a camera's RAW file by strobe-raw (host/external/raw_file.hpp).
Result<Photograph> load_photograph(const std::filesystem::path& path);

/// The same with each side so many times as long, by cubics between the pixels. What is saturated stays so.
Photograph enlarged(const Photograph& photograph, int factor);

/// The lowest number that a saturated pixel shows, in the file's own numbers (CV_8UC1 or CV_16UC1). A sensor
/// of fewer bits than the file saturates below the file's largest number (4095, or 4095·16 of 65535), and
/// lossy compression or a full well spreads it: the largest numbers count as saturated if they form a peak
/// near the top of 8, 10, 12, 14 or 16 bits. Returns the largest number that the file can hold if they do
/// not.
double saturation_level(const cv::Mat& pixels);

}  // namespace strobe::digitize
