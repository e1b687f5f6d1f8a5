// A photograph's light as a screen shows it. Pure; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>

namespace strobe::digitize {

/// CV_8UC1 of Photograph::intensity: black and white at the 1st and 99.8th percentile, with a gamma of 0.5, so that dark
/// parts are visible. white: the number that white becomes, up to 255.
cv::Mat display_grey(const cv::Mat& intensity, double white = 255.0);

}  // namespace strobe::digitize
