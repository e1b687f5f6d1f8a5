// Variance components from residuals. Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Replaces the estimated variances by those of the residuals: sum of squares over (number of measurements -
/// trace of their rows of the hat matrix). A group without residuals keeps its first guess and has 0 degrees
/// of freedom. Returns the largest relative change of a standard deviation.
/// Source: Förstner's simplified estimator; Koch, Parameter Estimation and Hypothesis Testing, 3.6.
double estimate_variance_components(ShotFit& fit);

}  // namespace strobe::reduction
