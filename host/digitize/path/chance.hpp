// How many curves chance alone would lead as closely through as many points. Pure; thread-safe.
// Moisan, Stival: A probabilistic criterion to detect rigid point matches, IJCV 57 (2004): the a-contrario RANSAC.
#pragma once

#include <cstddef>
#include <span>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

/// Places are no better known than this, whatever the residuals.
inline constexpr double kMinResidual_px = 0.1;

/// log10 of the number of curves of `parameters` parameters expected by chance with `members` or more of `points`
/// points, thrown at random over the view, on a band that covers `share` of it (0 to 1). members <= points.
double log10_curves_by_chance(std::size_t points, std::size_t members, std::size_t parameters, double share);

/// What part of the view of these points, a diameter around them, a band along a path across it covers for each px of
/// its width.
double share_of_view_per_px(std::span<const PathPoint> points, std::span<const int> eligible,
                            double diameter_px);

}  // namespace strobe::digitize
