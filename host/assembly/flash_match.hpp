// Which flash made which image of the ball: order, spacing, straight flight and a contact that a ball can
// have. Of all assignments the most likely one is taken; what it leaves in ambiguity is said as a number.
// Deterministic, no I/O; thread-safe; allocates. 166 flashes and a dozen images take a fraction of a
// millisecond.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/assembly/track.hpp"

namespace strobe::host {

/// When the ball is expected at the surface, apart from the photograph. Weak: machines vary.
struct ArrivalPrior {
  double touchdown_s = 0.0;  ///< on the time axis of the flashes
  /// half-width of a Cauchy density; its long tails let a machine be well off its lag.
  double scale_s = 0.010;
};

struct FlashMatch {
  std::vector<int> flash;  ///< for each image the number of its flash among the seen ones, ascending
  /// For each seen flash, 1 if it lies within this or another plausible assignment.
  std::vector<char> may_show;
  double chi_squared = 0.0;  ///< straight flight of both legs
  /// What taking the wrong assignment is expected to add to the variance of the worst number, in units of
  /// that number's own variance; one assignment's error counts as at most 3 sd. 0 to 9.
  double ambiguity = 0.0;
  /// How probable it is that the images are of other flashes than said, 0 to 1. In an even train the
  /// intervals leave open which flashes they are, however sure the numbers; a coded train's tell.
  double misassignment_probability = 0.0;
};

/// More ambiguity than this is an ambiguous match: the stated sd would be 5 % too small, or the odds for numbers
/// that are off by 3 sd or more better than 1 to 90.
inline constexpr double kMaxAmbiguity = 0.1;
/// More misassignment_probability than this, and a coded train has not told which flashes made the images.
inline constexpr double kMaxMisassignmentProbability = 0.01;

/// Nothing if there are fewer flashes than images. times_s: seen flashes, ascending, any origin.
/// An assignment that nothing supports (no steady speed fits) is still given, in order, with ambiguity 9.
std::optional<FlashMatch> match_flashes(std::span<const double> times_s, const Track& track,
                                        const std::optional<ArrivalPrior>& prior);

}  // namespace strobe::host
