// What repeated measurements of one quantity say: mean, scatter, and how far chance moves either. Plain values.
#pragma once

#include <cmath>

#include "common/reduction/running_statistics.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::commission {

/// Uncertainties are 0 where fewer than two values leave them unknown.
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
  /// The true sd is smaller only as often as a normal deviate exceeds z (normal approximation of the logarithm).
  double sd_lower_bound(double z) const {
    return count() > 1 ? sd() * std::exp(-z / std::sqrt(2.0 * (count() - 1.0))) : 0.0;
  }

 private:
  reduction::RunningStatistics values_;
};

}  // namespace strobe::commission
