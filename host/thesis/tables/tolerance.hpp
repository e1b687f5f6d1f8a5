// Tolerances of derived values: how much the mean of a function of two quantities may differ from the
// function of the printed means, by the rounding of the inputs (half a digit each, first order) and by the
// spread of the replicates (second order: half the trace of Hessian times covariance, the largest over all
// correlations). Pure; thread-safe; no allocation.
#pragma once

#include "common/data/thesis_data.hpp"
#include "host/thesis/table.hpp"

namespace strobe::report {

/// Half a digit of the printed means, all of which have two decimals.
inline constexpr double kHalfDigit = 0.005;

struct DerivedValue {
  double value = 0.0;
  Tolerance tolerance;
};

DerivedValue angle_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy);
DerivedValue speed(const thesis::MeanSd& vx, const thesis::MeanSd& vy);
/// -vy_LO/vy_TD
DerivedValue restitution(const thesis::Condition& condition);
/// (vx_TD - vx_LO)/(vy_LO - vy_TD)
DerivedValue impulse_ratio(const thesis::Condition& condition);
/// Sd of the angle from those of the components and of the speed: sd(vx)² + sd(vy)² = sd(v)² + v²·sd(theta)²
/// to first order, whatever the correlation. The bound for the next order is (sd/v)² of the value, times
/// four.
DerivedValue angle_sd_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy, const thesis::MeanSd& v);

}  // namespace strobe::report
