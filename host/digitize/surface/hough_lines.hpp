// Where straight edges with light below them run across a photograph: a Hough transform over edges that vote
// in their own direction only (O'Gorman and Clowes 1976). Deterministic; thread-safe; allocates.
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
  double votes = 0.0;  ///< share of the width whose edges vote for it
};

/// What of a photograph is hidden, on a coarser grid.
struct OcclusionMask {
  cv::Mat mask;        ///< CV_8UC1, non-zero: hidden; empty: nothing is
  double scale = 1.0;  ///< photograph px per px of it

  bool at(int column, int row) const {
    return !mask.empty() && mask.at<uchar>(std::min(static_cast<int>(row / scale), mask.rows - 1),
                                           std::min(static_cast<int>(column / scale), mask.cols - 1)) != 0;
  }
};

/// The size and scale at which lines are searched.
cv::Size hough_image_size(cv::Size photograph);

/// The most voted first, at most `most`. `hidden`: of hough_image_size(), or empty; no edge there
/// counts.
std::vector<HoughLine> hough_lines(const Photograph& photograph, const OcclusionMask& hidden,
                                   std::size_t most);

}  // namespace strobe::digitize
