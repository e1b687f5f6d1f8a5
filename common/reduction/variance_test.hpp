// Whether residuals scatter more than their noise explains. Pure functions; thread-safe.
#pragma once

namespace strobe::reduction {

/// Share of clean photographs that each check of consistency may take for bad.
inline constexpr double kFalseAlarms = 1e-3;

/// Probability that normal errors give a sum of squares, over their variance, of at least this much.
/// `noise_freedom` are the degrees of freedom which that variance was estimated with: infinity where it is known
/// (chi squared), else F. 1 for no degrees of freedom.
/// Source: Koch, Parameter Estimation and Hypothesis Testing, 4.2 (the global test of an adjustment).
double chance_of_scatter(double sum_of_squares, double degrees_of_freedom, double noise_freedom);

}  // namespace strobe::reduction
