// First, coarse search for the line on one ball: a matched filter over angle, tilt and width. Thread-safe;
// allocates.
#pragma once

#include <vector>

#include "host/digitize/equator/ball_pixels.hpp"

namespace strobe::digitize {

/// A local maximum of the filter over the angle.
struct LinePeak {
  EquatorLine line;
  double score = 0.0;  ///< z-score against chance; each column along the line counts alike, however dark
};

struct LineSearch {
  std::vector<LinePeak> peaks;  ///< best first, 8 degrees apart or more
  double visible = 0.0;         ///< fraction of a diameter, at the angle where it is largest
  double saturated = 0.0;       ///< fraction of the disc
  double outside = 0.0;         ///< fraction of the disc beyond the photograph's border
};

/// Which tilts of the line's plane are searched: those of a ball that spins about the line of sight, with
/// some play; or all up to where the line runs along the outline, which takes several times as long.
enum class TiltRange { slight, all };

LineSearch search_line(BallPixels& pixels, Effort effort, TiltRange range);

}  // namespace strobe::digitize
