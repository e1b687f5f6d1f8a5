// Which flash made which image of the ball: order, spacing, straight flight and a contact that a ball can
// have. Of all assignments the most likely one is taken; what it leaves in doubt is said as a probability.
// Deterministic, no I/O; thread-safe; allocates. 166 flashes and a dozen images take a fraction of a
// millisecond.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/assembly/image_track.hpp"

namespace strobe::host {

/// When the ball is expected at the surface, apart from the photograph. Weak: machines vary.
struct ArrivalPrior {
  double touchdown_s = 0.0;  ///< on the time axis of the flashes
  double scale_s =
      0.010;  ///< half-width of a Cauchy density; its long tails let a machine be well off its lag
};

struct FlashMatch {
  std::vector<int> flash;    ///< for each image the number of its flash among the seen ones, ascending
  double chi_squared = 0.0;  ///< straight flight of both legs
  double doubt = 0.0;        ///< probability, 0 to 1, of assignments that give other numbers than this one
};

/// More doubt than this is an ambiguous match: odds of less than 100 to 1 for the numbers shown.
inline constexpr double kMostDoubt = 0.01;

/// Nothing if there are fewer flashes than images. times_s: seen flashes, ascending, any origin.
/// An assignment that nothing supports (no steady speed fits) is still given, in order, with doubt 1.
std::optional<FlashMatch> match_flashes(std::span<const double> times_s, const Track& track,
                                        const std::optional<ArrivalPrior>& prior);

}  // namespace strobe::host
