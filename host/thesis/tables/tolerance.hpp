// How far the mean of a function of two means may lie from the function of the printed means: by the
// rounding of the inputs (half a digit each, first order), and by the spread of the replicates (second order:
// half the trace of Hessian times covariance, at most over all correlations). Pure; thread-safe; no
// allocation.
#pragma once

#include "common/data/thesis_data.hpp"
#include "host/thesis/table.hpp"

namespace strobe::report {

/// Half a digit of the printed means, all of which have two decimals.
inline constexpr double kHalfDigit = 0.005;

struct Derived {
  double value = 0.0;
  Allowance allowance;
};

Derived angle_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy);
Derived speed(const thesis::MeanSd& vx, const thesis::MeanSd& vy);
/// -vy_LO/vy_TD
Derived restitution(const thesis::Condition& condition);
/// (vx_TD - vx_LO)/(vy_LO - vy_TD)
Derived impulse_ratio(const thesis::Condition& condition);
/// Sd of the angle from those of the components and of the speed: sd(vx)² + sd(vy)² = sd(v)² + v²·sd(theta)²
/// to first order, whatever the correlation. The bound for the next order is (sd/v)² of the value, times
/// four.
Derived angle_sd_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy, const thesis::MeanSd& v);

}  // namespace strobe::report
