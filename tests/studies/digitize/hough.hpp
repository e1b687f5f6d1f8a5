// The plain way to find balls, to compare with: OpenCV's Hough transform for circles. Deterministic;
// thread-safe; allocates.
#pragma once

#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::studies::digitize {

struct HoughSettings {
  bool alternative = false;  ///< cv::HOUGH_GRADIENT_ALT (Xie and others) instead of cv::HOUGH_GRADIENT
  int reduction = 4;         ///< the photograph is made smaller by it first
  double edge = 100.0;       ///< param1, Canny's upper threshold of the picture stretched to 8 bits
  double support = 30.0;     ///< param2
};

/// What is tried, each over all photographs; the best one is its figure.
std::vector<HoughSettings> hough_trials();

std::string text_of(const HoughSettings& settings);

/// Circles of the ball's size within the tolerance, in plane px.
reduction::Frame hough_circles(const strobe::digitize::Photograph& photograph,
                               const strobe::digitize::DigitizeSettings& ball, const HoughSettings& settings);

}  // namespace strobe::studies::digitize
