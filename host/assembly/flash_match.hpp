// Which flash made which image of the ball: the most likely assignment by order, spacing, ballistic flight and
// a plausible contact, and how ambiguous it is.
// Deterministic, no I/O; thread-safe; allocates. 166 flashes and a dozen images take a fraction of a
// millisecond.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/assembly/track.hpp"

namespace strobe::host {

/// When the ball is expected at the surface, from the gate or the machine's lag. A weak prior.
struct ArrivalPrior {
  double touchdown_s = 0.0;  ///< on the time axis of the flashes
  /// Half-width of a Cauchy density, whose long tails allow for a machine far off its usual lag.
  double scale_s = 0.010;
};

struct FlashMatch {
  std::vector<int> flash;  ///< for each image the number of its flash among the observed ones, ascending
  /// For each observed flash, 1 if it lies within this or another plausible assignment.
  std::vector<char> possibly_imaged;
  double chi_squared = 0.0;  ///< straight flight of both legs
  /// Expected increase of the worst number's variance by wrong assignments, in units of that variance; an
  /// assignment's error counts as at most 3 sd. 0 to 9.
  double ambiguity = 0.0;
  /// Probability that the images are of other flashes, 0 to 1. The intervals of an even train leave open which
  /// flashes they are, however certain the numbers; those of a coded train tell.
  double misassignment_probability = 0.0;
};

/// Above this a match is ambiguous: the stated sd would be 5 % too small, or numbers that are off by 3 sd or
/// more have odds of more than 1 to 90.
inline constexpr double kMaxAmbiguity = 0.1;
/// Above this the code of a coded train leaves open which flashes made the images.
inline constexpr double kMaxMisassignmentProbability = 0.01;

/// times_s: observed flashes, ascending, any origin. Returns nullopt if there are fewer flashes than images.
/// If no steady speed fits, the images are assigned to consecutive flashes, with ambiguity 9.
std::optional<FlashMatch> match_flashes(std::span<const double> times_s, const Track& track,
                                        const std::optional<ArrivalPrior>& prior);

}  // namespace strobe::host
