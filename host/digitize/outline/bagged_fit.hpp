// An outline measured several times over, cut into stretches of other lengths and looked at over other
// depths, and the middle of what comes out. Which stretches stand and which are taken for something else
// depends on the cut, so that single results differ by about as much as they err: their middle is nearer to
// the truth, above all where little is seen (bagging, Breiman 1996). Deterministic; thread-safe; allocates.
#pragma once

#include "host/digitize/outline/outline_fit.hpp"

namespace strobe::digitize {

/// As fit_outline(), for some five times the work. The covariance holds how far the cuts disagree. Absent:
/// with no cut are there enough sectors with an edge.
std::optional<FittedOutline> fit_outline_bagged(const Photograph& photograph, const LocalFrame& frame,
                                                const OutlineShape& start, double sigma_px,
                                                std::span<const OutlineShape> neighbours,
                                                const OutlineFitSettings& settings);

}  // namespace strobe::digitize
