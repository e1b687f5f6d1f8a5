// What several steps judge by: repeated measurements of one quantity, how far chance moves them, and least
// squares of few unknowns. Plain values; pure; thread-safe; solve_normal() allocates.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "common/reduction/running_statistics.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::commission {

/// A deviation that is not chance: two-sided, of a normal, 6e-5.
inline constexpr double kCertain_sd = 4.0;
/// Of the scale over the whole width or height: speeds of either leg are then off by a quarter of it.
inline constexpr double kMaxSlope = 0.006;

/// Of repeated measurements: mean and scatter. Uncertainties are 0 where fewer than two values leave them
/// unknown.
class Sample {
 public:
  void add(double value) { values_.add(value); }
  int count() const { return static_cast<int>(values_.count()); }
  double mean() const { return values_.mean(); }
  double sd() const { return values_.sample_sd(); }
  double mean_sd() const { return count() > 1 ? sd() / std::sqrt(static_cast<double>(count())) : 0.0; }
  /// How far chance moves the mean, to either side with this probability: (0, 1), by Student's t.
  double mean_margin(double probability) const {
    return count() > 1 ? statistics::student_t_half_width(probability, count() - 1.0) * mean_sd() : 0.0;
  }
  /// The true sd is smaller only as often as a normal deviate exceeds z (normal approximation of the
  /// logarithm).
  double sd_lower_bound(double z) const {
    return count() > 1 ? sd() * std::exp(-z / std::sqrt(2.0 * (count() - 1.0))) : 0.0;
  }

 private:
  reduction::RunningStatistics values_;
};

/// The unknowns from the normal equations' matrix and right side. No template: one decomposition is compiled
/// for all sizes.
inline Eigen::VectorXd solve_normal(const Eigen::MatrixXd& information, const Eigen::VectorXd& right) {
  return information.ldlt().solve(right);
}

}  // namespace strobe::commission
