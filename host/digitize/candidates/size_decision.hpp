// Candidates of the ball's size, and which size that is: the one that is given, unless the picture's circles say
// otherwise (size_search.hpp), or the one that they agree on if none is given. The search for it is made only where
// the candidates of the given size leave doubt. Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct ExpectedSize {
  std::optional<double> diameter_px;  ///< plane px; absent: not known
  double tolerance = 0.08;            ///< relative
};

struct SizeDecision {
  std::optional<double> diameter_px;     ///< plane px, typical; absent: no size can be told
  double least_px = 0.0, most_px = 0.0;  ///< diameters of single balls
  std::vector<Candidate> candidates;     ///< best first
  /// The size that the picture's circles agree on, where it is not the one given: there are no candidates then.
  std::optional<double> contradicted_by_px;
};

SizeDecision decide_size(const Photograph& photograph, const PlaneMap& map, const ExpectedSize& expected,
                         Effort effort);

}  // namespace strobe::digitize
