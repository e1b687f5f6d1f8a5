// How many curves chance alone would lead as closely through as many points. Pure; thread-safe.
// Moisan, Stival: A probabilistic criterion to detect rigid point matches, IJCV 57 (2004): the a-contrario RANSAC.
#pragma once

#include <cstddef>

namespace strobe::digitize {

/// log10 of the number of curves of `parameters` parameters expected by chance with `members` or more of `points`
/// points, thrown at random over the view, on a band that covers `share` of it (0 to 1). members <= points.
double log10_curves_by_chance(std::size_t points, std::size_t members, std::size_t parameters, double share);

}  // namespace strobe::digitize
