// Flight under constant acceleration: the path of a ball's centre between flashes, where drag and lift are
// too small to matter. Axes along and normal to the surface (x in the direction of travel, y up from it).
// Units: m, s, m/s, m/s². Pure functions of plain values: thread-safe, real-time safe.
#pragma once

#include <optional>

namespace strobe::flight {

inline constexpr double kStandardGravity_mps2 = 9.80665;

struct Vector {
  double x = 0.0;
  double y = 0.0;
};

/// Acceleration of free fall in the surface's axes, for a surface inclined by `inclination_rad`
/// (counter-clockwise positive as the camera sees it; 0 = level).
Vector gravity_mps2(double inclination_rad);

/// Position and velocity at t = 0 and a constant acceleration. All values finite, of magnitude up to 1e100.
struct Parabola {
  Vector position_m;
  Vector velocity_mps;
  Vector acceleration_mps2;

  Vector position_at(double time_s) const;
  Vector velocity_at(double time_s) const;

  /// When the centre passes `height_m` on its way down (vy <= 0) or up (vy >= 0); may lie before t = 0.
  /// Absent when it never does so (nor within 1e100 s). At the very top or bottom of the path both give the
  /// same instant.
  std::optional<double> time_falling_through_s(double height_m) const;
  std::optional<double> time_rising_through_s(double height_m) const;
};

}  // namespace strobe::flight
