// Candidates for the ball's images: edge points vote for the centres that their gradients point to (Hough
// transform for circles). Finds complete and partly visible outlines, overlapping ones too (exposure adds up,
// so that each outline is complete unless it is saturated), and false positives, which later stages reject.
// Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct SearchRange {
  double radius_min_px = 0.0;  ///< of the ball on the photograph, image px, > 3
  double radius_max_px = 0.0;
  double min_coverage = 0.2;  ///< smallest visible fraction of an outline
};

/// Best first, at least a tenth of the radius apart. Centres are good to about a pixel of the photograph
/// (fast: two). Returns none for radii of 3 px or less or larger than the photograph.
std::vector<Candidate> find_candidates(const Photograph& photograph, const SearchRange& range, Effort effort);

// Candidates of the ball's size, and which size that is: the one that is given, unless the picture's circles
// say otherwise, or the one that they agree on if none is given. The search for it is made only where the
// candidates of the given size leave doubt. Deterministic for any number of threads; thread-safe; allocates.

struct ExpectedSize {
  std::optional<double> diameter_px;  ///< plane px; absent: not known
  double tolerance = 0.08;            ///< relative
};

struct SizeDecision {
  std::optional<double> diameter_px;     ///< plane px, typical; absent: no size can be told
  double least_px = 0.0, most_px = 0.0;  ///< diameters of single balls
  std::vector<Candidate> candidates;     ///< best first
  /// The size that the picture's circles agree on, where it is not the one given: there are no candidates
  /// then.
  std::optional<double> contradicted_by_px;
};

SizeDecision decide_size(const Photograph& photograph, const PlaneMap& map, const ExpectedSize& expected,
                         Effort effort);

}  // namespace strobe::digitize
