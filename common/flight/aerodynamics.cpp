#include "common/flight/aerodynamics.hpp"

#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::flight {
namespace {

/// Newton steps for the jerk. Its relative effect on the time, a t / v, is squared at each: three reach
/// rounding.
std::optional<double> refined(const Flight& flight, std::optional<double> time_s, double height_m) {
  if (!time_s || flight.forcing.jerk_mps3.y() == 0.0) return time_s;
  for (int step = 0; step < 3; ++step) {
    const double vy = flight.velocity_at(*time_s).y();
    if (vy == 0.0) return time_s;
    *time_s -= (flight.position_at(*time_s).y() - height_m) / vy;
  }
  return time_s;
}

}  // namespace

double lift_coefficient(double radius_m, double omega_radps, double speed_mps, const AirLaw& law) {
  const double rim_mps = radius_m * std::abs(omega_radps);
  if (!(rim_mps > 0.0) || !(law.lift_offset > 0.0)) return 0.0;
  return rim_mps / (law.lift_slope * rim_mps + law.lift_offset * speed_mps);
}

double Aerodynamics::lift_mps2(double speed_mps, double omega_radps) const {
  const double lift =
      lift_per_m * lift_coefficient(radius_m, omega_radps, speed_mps, law) * speed_mps * speed_mps;
  return std::copysign(lift, omega_radps);
}

Aerodynamics aerodynamics(const ball::Ball& ball, double air_density_kgpm3, Effects effects,
                          const AirLaw& law) {
  const double radius = ball.radius_m();
  const double per_m = 0.5 * air_density_kgpm3 * kPi * radius * radius / ball.mass_kg;
  const bool lifts = effects.magnus && law.lift_offset > 0.0;
  return {effects.drag ? per_m * law.drag_coefficient : 0.0, lifts ? per_m : 0.0, radius, law};
}

Forcing forcing(const Aerodynamics& air, const Eigen::Vector2d& gravity_mps2, const Eigen::Vector2d& v,
                double omega_radps, double more_lift_per_s) {
  const double speed = std::hypot(v.x(), v.y());
  if (!(speed > 0.0)) return {gravity_mps2};
  // Lift is f(speed) (z x v) with f = lift_per_m R omega speed / (slope R|omega| + offset speed).
  const double rim = air.radius_m * omega_radps;
  const double sum = air.law.lift_slope * std::abs(rim) + air.law.lift_offset * speed;
  const double f = air.lift_per_m * rim * speed / sum + more_lift_per_s;
  const double df = air.lift_per_m * rim * (air.law.lift_slope * std::abs(rim) / sum) / sum;  // by the speed
  const double drag = air.drag_per_m * speed;
  const Eigen::Vector2d a{gravity_mps2.x() - drag * v.x() - f * v.y(),
                          gravity_mps2.y() - drag * v.y() + f * v.x()};
  const Eigen::Vector2d unit = v / speed;
  Eigen::Matrix2d by_velocity;
  by_velocity << -drag - air.drag_per_m * v.x() * unit.x() - df * v.y() * unit.x(),
      -air.drag_per_m * v.x() * unit.y() - f - df * v.y() * unit.y(),
      -air.drag_per_m * v.y() * unit.x() + f + df * v.x() * unit.x(),
      -drag - air.drag_per_m * v.y() * unit.y() + df * v.x() * unit.y();
  return {a, by_velocity * a, by_velocity};
}

Eigen::Vector2d Flight::position_at(double t) const {
  return position_m +
         t * (velocity_mps + t * (forcing.acceleration_mps2 / 2.0 + forcing.jerk_mps3 * t / 6.0));
}

Eigen::Vector2d Flight::velocity_at(double t) const {
  return velocity_mps + t * (forcing.acceleration_mps2 + forcing.jerk_mps3 * t / 2.0);
}

std::optional<double> Flight::time_falling_through_s(double height_m) const {
  const Parabola parabola{position_m, velocity_mps, forcing.acceleration_mps2};
  return refined(*this, parabola.time_falling_through_s(height_m), height_m);
}

std::optional<double> Flight::time_rising_through_s(double height_m) const {
  const Parabola parabola{position_m, velocity_mps, forcing.acceleration_mps2};
  return refined(*this, parabola.time_rising_through_s(height_m), height_m);
}

}  // namespace strobe::flight
