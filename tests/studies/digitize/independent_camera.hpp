// The independent renderer's camera: a lens with glare, a colour sensor with a Bayer mosaic and uneven pixels, and the
// curve by which its file's numbers follow the light. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <random>

namespace strobe::studies::digitize {

struct IndependentCamera {
  double blur_px = 0.8, glare = 0.03, vignetting = 0.2;
  double exposure = 1.0;  ///< times light: 1 saturates
  double noise = 1.0;     ///< over the usual
  double black = 0.0;     ///< light that a dark sensor shows
  double gamma = 1.0;
};

/// CV_16UC3, blue first, of the light of yellow felt and of grey things behind it (CV_32FC1; changed).
cv::Mat develop(const IndependentCamera& camera, cv::Mat felt, cv::Mat behind, std::mt19937_64& random);

}  // namespace strobe::studies::digitize
