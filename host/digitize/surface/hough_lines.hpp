// Straight edges across a photograph, brighter below: a Hough transform in which edge points vote for lines
// along their own direction only (O'Gorman and Clowes 1976). Deterministic; thread-safe; allocates.
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// row = row_px + slope·(column - middle of the photograph), image px.
struct HoughLine {
  double row_px = 0.0;
  double slope = 0.0;
  double votes = 0.0;  ///< over the photograph's width
};

/// The parts of a photograph that balls cover.
struct OcclusionMask {
  cv::Mat mask;        ///< CV_8UC1, non-zero: covered; empty: none is
  double scale = 1.0;  ///< photograph px per mask px

  bool at(int column, int row) const {
    return !mask.empty() && mask.at<uchar>(std::min(static_cast<int>(row / scale), mask.rows - 1),
                                           std::min(static_cast<int>(column / scale), mask.cols - 1)) != 0;
  }
};

/// Size of the downsampled picture in which lines are searched.
cv::Size hough_image_size(cv::Size photograph);

/// Most votes first. `occluded`: of hough_image_size(), or empty; edge points there do not vote.
std::vector<HoughLine> hough_lines(const Photograph& photograph, const OcclusionMask& hidden,
                                   std::size_t most);

}  // namespace strobe::digitize
