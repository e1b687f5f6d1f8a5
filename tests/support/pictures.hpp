// Pictures of tests as files. Colours have blue first, as OpenCV's. Throws on errors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"

namespace strobe::testing {

/// By the extension: .tif, .png, .jpg. Of 8 or 16 bits, but for .jpg.
std::vector<std::uint8_t> encoded_picture(const cv::Mat& pixels, const std::string& extension,
                                          const image::TiffOptions& options = {});

void write_picture(const std::filesystem::path& path, const cv::Mat& pixels);

/// TIFF, PNG and JPEG.
cv::Mat read_picture(const std::filesystem::path& path);

}  // namespace strobe::testing
