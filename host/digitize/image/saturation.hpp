// From which brightness on a photograph's pixels may have had any more light. Deterministic; thread-safe.
#pragma once

#include <opencv2/core.hpp>

namespace strobe::digitize {

/// The lowest number that a saturated pixel shows, in the photograph's own numbers (CV_8UC1 or CV_16UC1). A
/// sensor of fewer bits than the file saturates below the file's largest number (4095 or 4095·16 of 65535),
/// and lossy compression or a sensor's full well spreads it: a photograph's largest numbers are taken for
/// saturated where they are heaped up near the top of 8, 10, 12, 14 or 16 bits. No such heap: the largest
/// number that the file can hold.
double saturation_level(const cv::Mat& pixels);

}  // namespace strobe::digitize
