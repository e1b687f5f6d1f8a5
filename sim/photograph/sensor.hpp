// From light on the sensor to pixel values: lens blur, vignetting, shot and read noise, saturation,
// bits. Deterministic for any number of threads; allocates.
#pragma once

#include <opencv2/core.hpp>

#include "sim/photograph/appearance.hpp"

namespace strobe::sim {

/// Blurs light (CV_32FC1) in place: the disc of a point out of focus, and the lens's own blur.
void blur(cv::Mat& light, double blur_px, double defocus_px);

/// Numbers of light (1 saturates): CV_8UC1 for 8 bits, else CV_16UC1.
cv::Mat develop(const cv::Mat& light, const PhotographSettings& settings, const Appearance& appearance);

}  // namespace strobe::sim
