// A leg of the ball's flight: the path through the centres of its images, and where it meets the surface.
// Lengths are in any one unit (m, or px of the photograph). Plain values; thread-safe, real-time safe, no
// allocation.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/flight/parabola.hpp"
#include "common/geometry/regression.hpp"

namespace strobe::geometry {

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

/// Touchdown (a path that falls at nearest_s, the time of the image next to the surface) or lift-off (one that rises
/// then): where the centre is at `height`. A leg between two bounces has both. Returns nullopt if the path does not
/// pass it so, or has no velocity along y.
std::optional<Crossing> crossing(const LegFit& leg, double height, double nearest_s);

}  // namespace strobe::geometry
