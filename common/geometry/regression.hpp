// Weighted linear regression of a number or a vector on one variable. Plain value; thread-safe, real-time
// safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <type_traits>

namespace strobe::geometry {

/// value = mean + slope (x - mean_x), by weighted least squares, one sample at a time.
/// Source: West, Updating mean and variance estimates, CACM 22 (1979): however unlike the weights, no moment
/// vanishes by rounding. Value: double or a fixed-size Eigen vector whose components share the weights.
template <typename Value>
class LinearRegression {
 public:
  /// weight > 0: the value's inverse variance, or 1.
  void add(double x, const Value& value, double weight) {
    const double dx = x - mean_x_;
    const Value dv = value - mean_;
    const double moment = weight * (weight_ / (weight_ + weight)) * dx;
    weight_ += weight;
    const double step = weight / weight_;
    mean_x_ += step * dx;
    mean_ += step * dv;
    sxx_ += moment * dx;
    sxv_ += moment * dv;
  }

  double weight() const { return weight_; }  ///< sum of the weights
  double mean_x() const { return mean_x_; }
  const Value& mean() const { return mean_; }
  double moment() const { return sxx_; }       ///< weighted sum of squares of x about its mean
  Value slope() const { return sxv_ / sxx_; }  ///< valid: two x differ
  Value at(double x) const { return mean_ + slope() * (x - mean_x_); }
  /// Variances for weights that are inverse variances, else in units of the samples' own.
  double slope_variance() const { return 1.0 / sxx_; }
  double variance_at(double x) const { return 1.0 / weight_ + (x - mean_x_) * (x - mean_x_) / sxx_; }

 private:
  static Value zero() {
    if constexpr (std::is_arithmetic_v<Value>) {
      return 0.0;
    } else {
      return Value::Zero();
    }
  }

  double weight_ = 0.0;
  double mean_x_ = 0.0;
  Value mean_ = zero();
  double sxx_ = 0.0;
  Value sxv_ = zero();
};

}  // namespace strobe::geometry
