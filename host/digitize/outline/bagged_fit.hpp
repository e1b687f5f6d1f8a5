// An outline fitted several times, with sectors of other lengths and depths, and the mean of the middle half
// of the results. Which sectors are outliers depends on the sectors, so that single results differ by about
// as much as their errors: the mean is closer to the truth, above all where little is visible (bagging,
// Breiman 1996). Deterministic; thread-safe; allocates.
#pragma once

#include "host/digitize/outline/outline_fit.hpp"

namespace strobe::digitize {

/// As fit_outline(), at some five times the cost. The covariance includes how far the fits differ. Returns
/// nullopt if none of them has enough sectors with an edge.
std::optional<FittedOutline> fit_outline_bagged(const Photograph& photograph, const LocalFrame& frame,
                                                const OutlineShape& start, double sigma_px,
                                                std::span<const OutlineShape> neighbours,
                                                const OutlineFitSettings& settings);

}  // namespace strobe::digitize
