// Noise levels from residuals. Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Replaces the estimated levels by those of the residuals: sum of squares over (number of measurements -
/// trace of their share in the fit). A level without residuals keeps its guess and has 0 degrees of freedom.
/// Returns the largest relative change of a level.
double estimate_variance_components(ShotFit& fit);

}  // namespace strobe::reduction
