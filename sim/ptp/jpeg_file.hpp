// The JPEG that a camera writes beside its RAW file. Thread-safe for different files; writes files.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/result.hpp"

namespace strobe::sim::ptp {

/// Grey, of 8 bits; numbers of 16 bits up to `white` are scaled to it. The error names the file.
Result<void> write_jpeg(const std::filesystem::path& path, const cv::Mat& pixels, int white);

}  // namespace strobe::sim::ptp
