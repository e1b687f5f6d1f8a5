// Candidates for the ball's images: edge points vote for the centres that their gradients point to (Hough
// transform for circles). Finds complete and partly visible outlines, overlapping ones too (exposure adds up,
// so that each outline is complete unless it is saturated), and false positives, which later stages reject.
// Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <vector>

#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct SearchRange {
  double radius_min_px = 0.0;  ///< of the ball on the photograph, image px, > 3
  double radius_max_px = 0.0;
  double min_coverage = 0.2;  ///< smallest visible fraction of an outline
};

/// Circles seen for this much are balls: texture, seams and shadows support half of a circle at most, and chance
/// another tenth.
inline constexpr double kCertainCoverage = 0.65;

/// Best first, at least a tenth of the radius apart. Centres are good to about a pixel of the photograph
/// (fast: two). Returns none for radii of 3 px or less or larger than the photograph.
std::vector<Candidate> find_candidates(const Photograph& photograph, const SearchRange& range, Effort effort);

}  // namespace strobe::digitize
