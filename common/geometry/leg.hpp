// A leg of the ball's flight: the path through the centres of its images, and where it meets the surface; and
// the regression that it is fitted by. Lengths are in any one unit (m, or px of the photograph). Plain
// values; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <type_traits>

#include "common/flight/parabola.hpp"

namespace strobe::geometry {

/// Linear regression of a number or a vector on one variable: value = mean + slope (x - mean_x), by weighted
/// least squares, one sample at a time.
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

/// Flight under known gravity through images at known times, by weighted least squares: a straight line once
/// gravity's fall is taken off.
class LegFit {
 public:
  explicit LegFit(const Eigen::Vector2d& gravity_per_s2) : gravity_(gravity_per_s2) {}

  /// weight > 0: inverse variance of each coordinate, or 1.
  void add(double time_s, const Eigen::Vector2d& centre, double weight = 1.0);

  int count() const { return count_; }
  bool has_velocity() const { return count_ >= 2 && line_.moment() > 0.0; }
  double mean_time_s() const { return line_.mean_x(); }
  /// Path about mean_time_s(). Valid with has_velocity().
  flight::Parabola path() const;
  /// Of each component; in units of the centres' own variance where weights were 1.
  double velocity_variance() const { return line_.slope_variance(); }
  double position_variance(double time_s) const { return line_.variance_at(time_s); }

 private:
  Eigen::Vector2d fall(double time_s) const {
    const double t = time_s - first_s_;
    return 0.5 * t * t * gravity_;
  }

  Eigen::Vector2d gravity_;
  int count_ = 0;
  double first_s_ = 0.0;
  LinearRegression<Eigen::Vector2d> line_;
};

/// Where a path passes a height.
struct Crossing {
  double time_s = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< per second
};

/// Touchdown (a path that falls at nearest_s, the time of the image next to the surface) or lift-off (one
/// that rises then): where the centre is at `height`. A leg between two bounces has both. Returns nullopt if
/// the path does not pass it so, or has no velocity along y.
std::optional<Crossing> crossing(const LegFit& leg, double height, double nearest_s);

}  // namespace strobe::geometry
