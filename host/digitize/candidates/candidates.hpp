// Where images of the ball may be: every gradient votes for the centre that it points to. Finds each whole or
// half-seen outline, also within overlaps (exposure adds up, so that the whole outline of each image is there
// unless it is saturated), and some that are none: the later stages sort those out. Deterministic for any
// number of threads; thread-safe; allocates.
#pragma once

#include <vector>

#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct SearchRange {
  double radius_min_px = 0.0;  ///< of the ball on the photograph, image px, > 3
  double radius_max_px = 0.0;
  /// Shortest side of outline, as a share of the whole, that makes a candidate.
  double min_coverage = 0.2;
};

/// Best first; none for radii of 3 px or less or larger than the photograph; no two closer than a tenth of
/// the radius. Centres to about a pixel of the photograph (fast: two).
std::vector<Candidate> find_candidates(const Photograph& photograph, const SearchRange& range, Effort effort);

}  // namespace strobe::digitize
