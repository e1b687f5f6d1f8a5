// Flight under constant acceleration: the path of a ball's centre between flashes, where drag and lift are
// too small to matter. Axes along and normal to the surface (x in the direction of travel, y up from it).
// Pure functions of plain values: thread-safe, real-time safe.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/flight/gravity.hpp"

namespace strobe::flight {

/// Acceleration of free fall in the surface's axes, for a surface inclined by `inclination_rad`
/// (counter-clockwise positive as the camera sees it; 0 = level).
Eigen::Vector2d gravity_mps2(double inclination_rad);

/// Position and velocity at t = 0 and a constant acceleration, in any one unit of length (m, or px of a
/// photograph) and seconds. All values finite, of magnitude up to 1e100.
struct Parabola {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  Eigen::Vector2d acceleration = Eigen::Vector2d::Zero();

  Eigen::Vector2d position_at(double time_s) const;
  Eigen::Vector2d velocity_at(double time_s) const;

  /// When the centre passes `height` on its way down (vy <= 0) or up (vy >= 0); may lie before t = 0.
  /// Returns nullopt if it never does so, or not within 1e100 s. At the very top or bottom of the path both
  /// give the same instant.
  std::optional<double> time_falling_through_s(double height) const;
  std::optional<double> time_rising_through_s(double height) const;
};

}  // namespace strobe::flight
