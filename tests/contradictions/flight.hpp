// A ball's flight through air by direct integration (Runge and Kutta's fourth order): gravity, drag, Magnus lift and
// the spin's decay. Shares no code with what it tests. Axes: x in the direction of travel, y up from the surface, spin
// counter-clockwise positive (backspin). Pure functions of plain values: thread-safe.
#pragma once

#include <numbers>

namespace strobe::contradictions {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;

struct Motion {
  double x_m = 0.0, y_m = 0.0;
  double vx_mps = 0.0, vy_mps = 0.0;
  double angle_rad = 0.0;  ///< of the equator
  double omega_radps = 0.0;
};

/// dv/dt = g - q C_D |v| v + q C_L |v| (z x v), q = density pi R^2 / (2 m), C_L = R omega / (2 R |omega| + |v|);
/// domega/dt = -decay |v| omega.
struct Forces {
  double gx_mps2 = 0.0, gy_mps2 = 0.0;
  double drag_per_m = 0.0;  ///< q C_D
  double lift_per_m = 0.0;  ///< q
  double decay_per_m = 0.0;
  double radius_m = 0.0325;
};

/// The motion `duration_s` later, or earlier where it is negative. Steps of at most 2 ms: forces change by some
/// hundredths in one, so that the error is below 1e-10 of the forces' part.
Motion flown(const Motion& from, const Forces& forces, double duration_s);

}  // namespace strobe::contradictions
