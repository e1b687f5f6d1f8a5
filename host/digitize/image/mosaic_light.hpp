// The light on a colour sensor, grey, from its mosaic (common/image/raster.hpp). No colour is interpolated.
// Each pixel is the sum of the numbers of the 3 x 3 around it with the weights 1 2 1, 2 4 2, 1 2 1: whatever
// its own colour, red and blue have a quarter of the weight in it and green a half, each symmetric about it,
// so that no edge moves and things of any colours make no pattern. Sums of plain counts are also what
// measures light best where its own noise prevails. What the sum blurs comes back from the pixel's own
// number: a quarter of what it exceeds the same colour's numbers around it by (1 0 2 0 1 across and down)
// takes the blur's variance away. One gain for each colour makes that part as large as the sum's, from the
// picture's own bright things. All is linear and symmetric: a thing of another colour has edges a little less
// even, but in their places.
#pragma once

#include <opencv2/core.hpp>

#include "common/image/raster.hpp"

namespace strobe::digitize {

struct MosaicLight {
  cv::Mat light;           ///< CV_32FC1: 0 in the dark, at most `saturation`
  float saturation = 1.0;  ///< from here on a colour's pixels may be full; up to 1
};

/// numbers: CV_16UC1; a pixel is full from `full` on. Pure; thread-safe; allocates.
MosaicLight mosaic_light(const cv::Mat& numbers, const image::Mosaic& mosaic, double full);

}  // namespace strobe::digitize
