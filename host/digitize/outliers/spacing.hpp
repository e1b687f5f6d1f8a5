// Images of a leg that are too close to each other: the ball is at one place at a time and flies as steadily
// as the lamps flash. Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

struct TooClose {
  int index = 0;      ///< of the rejected point
  int neighbour = 0;  ///< of the better one next to it
  double distance_px = 0.0;
};

/// Of two neighbours less than half the leg's median step apart, the one of clearly less `quality` (0 to 1,
/// as steps may be unequal on purpose). If the flashes' times are known, and no two of them are close enough
/// to explain it, the one of less quality however little; if they are not known, so on straight legs where a
/// step is less than a tenth of the median one. Legs of fewer than 4 images are not checked.
std::vector<TooClose> find_too_close(const Path& path, std::span<const PathPoint> points,
                                     std::span<const double> quality, std::span<const double> flash_times_s);

}  // namespace strobe::digitize
