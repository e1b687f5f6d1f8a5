// Statistics of a series of shots. Plain values, not thread-safe; real-time safe.
#pragma once

#include <cmath>
#include <cstddef>

namespace strobe::reduction {

/// Mean and standard deviation in one pass (Welford 1962), stable however alike the values are.
class RunningStatistics {
 public:
  void add(double value) {
    ++count_;
    const double from_mean = value - mean_;
    mean_ += from_mean / static_cast<double>(count_);
    squares_ += from_mean * (value - mean_);
  }
  std::size_t count() const { return count_; }
  double mean() const { return mean_; }  ///< 0 if there is none
  /// Root mean square deviation from the mean, dividing by n as the thesis does.
  double population_sd() const {
    return count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) : 0.0;
  }
  /// Dividing by n - 1; 0 for fewer than two values.
  double sample_sd() const {
    const auto n = static_cast<double>(count_);
    return n > 1.0 ? population_sd() * std::sqrt(n / (n - 1.0)) : 0.0;
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;
};

}  // namespace strobe::reduction
