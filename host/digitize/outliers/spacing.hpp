// Images of a leg that are too near to each other for one ball: it is at one place at a time, and flies past
// as steadily as the lamps flash. Deterministic; no photograph; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

struct TooClose {
  int index = 0;  ///< of the point that is one too many
  int by = 0;     ///< of the better one next to it
  double apart_px = 0.0;
};

/// Of two neighbours less than half a leg's usual step apart the one of clearly less quality (0 to 1: how much
/// of a ball is seen), as steps may be unequal by intent. Where the flashes' times are known, and no two of
/// them are near enough to explain it, the one of less quality however little. Legs of fewer than 4 images tell
/// no usual step.
std::vector<TooClose> find_too_close(const Path& path, std::span<const PathPoint> points,
                                     std::span<const double> quality, std::span<const double> flash_times_s);

}  // namespace strobe::digitize
