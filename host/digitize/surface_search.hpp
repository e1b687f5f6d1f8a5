// Where straight edges with light below them run across a photograph: a Hough transform over edges that vote
// in their own direction only (O'Gorman and Clowes 1976). Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "host/digitize/photograph.hpp"

namespace strobe::digitize {

/// row = row_px + slope·(column - middle of the photograph), image px.
struct RoughLine {
  double row_px = 0.0;
  double slope = 0.0;
  double votes = 0.0;  ///< share of the width whose edges vote for it
};

/// The most voted first, at most `most`. `mask`: CV_8UC1 of the photograph's size or empty; non-zero: no edge
/// there counts.
std::vector<RoughLine> rough_lines(const Photograph& photograph, const cv::Mat& mask, std::size_t most);

}  // namespace strobe::digitize
