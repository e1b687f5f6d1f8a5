// Air on a ball in flight: drag against the motion and the Magnus lift across it, and a flight with them over
// the few milliseconds of a flash train. Axes as for parabola.hpp; spin counter-clockwise positive, so that
// backspin (omega > 0 for a ball moving along +x) lifts. Coefficients: air_law.hpp. Pure functions of plain
// values: thread-safe, real-time safe, no allocation.
#pragma once

#include <optional>

#include "common/ball/ball.hpp"
#include "common/flight/air_law.hpp"
#include "common/flight/effects.hpp"
#include "common/flight/parabola.hpp"

namespace strobe::flight {

/// Dry air at 20 degrees Celsius and 101 325 Pa.
inline constexpr double kAirDensity_kgpm3 = 1.204;

/// Dry air at 101 325 Pa, ideal gas. Valid above -273.15 degrees Celsius.
constexpr double air_density_kgpm3(double temperature_degC) {
  return kAirDensity_kgpm3 * 293.15 / (273.15 + temperature_degC);
}

/// Lift coefficient C_L, 0 without spin, at most law.greatest_lift(). radius_m > 0, speed >= 0.
double lift_coefficient(double radius_m, double omega_radps, double speed_mps, const AirLaw& law = {});

/// What one ball feels in one air.
struct Aerodynamics {
  double drag_per_m = 0.0;  ///< drag over m v^2: rho A C_D / (2 m)
  double lift_per_m = 0.0;  ///< lift over m v^2 C_L: rho A / (2 m)
  double radius_m = 0.5 * ball::kThesisDiameter_m;
  AirLaw law{};  ///< drag_per_m is by its coefficient

  /// Deceleration along the path, positive, and lift, positive for backspin. [m/s^2]
  double drag_mps2(double speed_mps) const { return drag_per_m * speed_mps * speed_mps; }
  double lift_mps2(double speed_mps, double omega_radps) const;
};

/// The ball's, leaving out what `effects` leaves out. diameter_m, mass_kg and density > 0.
Aerodynamics aerodynamics(const ball::Ball& ball, double air_density_kgpm3, Effects effects = {},
                          const AirLaw& law = {});

/// Acceleration at one velocity, its derivative by the velocity, and how fast it changes along the path.
struct Forcing {
  Eigen::Vector2d acceleration_mps2 = Eigen::Vector2d::Zero();
  Eigen::Vector2d jerk_mps3 = Eigen::Vector2d::Zero();
  Eigen::Matrix2d by_velocity_per_s = Eigen::Matrix2d::Zero();
};

/// Of a ball with velocity and (constant) spin, in gravity. The jerk is the exact time derivative of the
/// acceleration there. `more_lift_per_s`: lift over speed, as acceleration, besides that of the spin.
Forcing forcing(const Aerodynamics& air, const Eigen::Vector2d& gravity_mps2,
                const Eigen::Vector2d& velocity_mps, double omega_radps, double more_lift_per_s = 0.0);

/// Flight as a third-order series about t = 0: position and velocity there, acceleration and jerk. What is
/// left out is the fourth order: at 45 m/s (drag 39 m/s^2) 0.002 mm/s and 5 nm after 6 ms, at 17 m/s a
/// hundredth of that.
struct Flight {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();
  Forcing forcing;

  Eigen::Vector2d position_at(double time_s) const;
  Eigen::Vector2d velocity_at(double time_s) const;

  /// When the centre passes `height_m` on its way down or up, as for Parabola: the parabola's instant,
  /// corrected for the jerk by Newton steps. Returns nullopt if the parabola never does so.
  std::optional<double> time_falling_through_s(double height_m) const;
  std::optional<double> time_rising_through_s(double height_m) const;
};

}  // namespace strobe::flight
