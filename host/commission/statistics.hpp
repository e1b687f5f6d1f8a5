// What several steps judge by: repeated measurements of one quantity, where their truth is, and least
// squares of few unknowns. Plain values; pure; thread-safe; solve_normal() allocates.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "common/reduction/running_statistics.hpp"
#include "common/statistics/distributions.hpp"
#include "host/commission/guard_band.hpp"

namespace strobe::commission {

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
  /// Half the interval of the mean, by Student's t; infinite where the scatter is not known.
  double mean_margin() const {
    return count() > 1 ? statistics::student_t_half_width(kGuardProbability, count() - 1.0) * mean_sd()
                       : std::numeric_limits<double>::infinity();
  }
  Interval mean_interval() const { return {mean() - mean_margin(), mean() + mean_margin()}; }
  /// By chi squared. Of one value: all that is possible.
  Interval sd_interval() const {
    if (count() < 2) return {0.0, std::numeric_limits<double>::infinity()};
    constexpr double kTail = 0.5 * (1.0 - kGuardProbability);
    const double freedom = count() - 1.0;
    const auto end = [&](double below) {
      return sd() * std::sqrt(freedom / statistics::chi_squared_quantile(freedom, below));
    };
    return {end(1.0 - kTail), end(kTail)};
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
