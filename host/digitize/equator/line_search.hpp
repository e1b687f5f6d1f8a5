// A first, rough look for the line on one ball: a matched filter over its angle, tilt and width. Thread-safe;
// allocates.
#pragma once

#include <vector>

#include "host/digitize/equator/ball_pixels.hpp"

namespace strobe::digitize {

/// An angle at which something line-like lies across the disc's middle.
struct LinePeak {
  EquatorLine line;
  double score = 0.0;  ///< how many sd of chance, every stretch of the line counting alike, however dark
};

struct LineSearch {
  std::vector<LinePeak> peaks;  ///< best first, 8 degrees apart or more
  double seen = 0.0;            ///< share of a diameter that is seen, at the angle where most is
  double saturated = 0.0;       ///< share of the disc
  double outside = 0.0;         ///< share of the disc beyond the photograph's border
};

LineSearch search_line(BallPixels& rows, Effort effort);

}  // namespace strobe::digitize
