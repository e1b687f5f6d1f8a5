#include "common/flight/aerodynamics.hpp"

#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::flight {
namespace {

/// The jerk moves the crossing by a share a t / v of itself, squared at each step: three reach rounding.
std::optional<double> corrected(const Flight& flight, std::optional<double> time_s, double height_m) {
  if (!time_s || flight.forcing.jerk_mps3.y == 0.0) return time_s;
  for (int step = 0; step < 3; ++step) {
    const double vy = flight.velocity_at(*time_s).y;
    if (vy == 0.0) return time_s;
    *time_s -= (flight.position_at(*time_s).y - height_m) / vy;
  }
  return time_s;
}

}  // namespace

double lift_coefficient(double radius_m, double omega_radps, double speed_mps) {
  const double rim_mps = radius_m * std::abs(omega_radps);
  return rim_mps > 0.0 ? rim_mps / (2.0 * rim_mps + speed_mps) : 0.0;
}

double Aerodynamics::lift_mps2(double speed_mps, double omega_radps) const {
  const double lift = lift_per_m * lift_coefficient(radius_m, omega_radps, speed_mps) * speed_mps * speed_mps;
  return std::copysign(lift, omega_radps);
}

Aerodynamics aerodynamics(const ball::Ball& ball, double air_density_kgpm3, Effects effects) {
  const double radius = ball.radius_m();
  const double per_m = 0.5 * air_density_kgpm3 * kPi * radius * radius / ball.mass_kg;
  return {effects.drag ? per_m * kDragCoefficient : 0.0, effects.magnus ? per_m : 0.0, radius};
}

Forcing forcing(const Aerodynamics& air, Vector gravity_mps2, Vector v, double omega_radps) {
  const double speed = std::hypot(v.x, v.y);
  if (!(speed > 0.0)) return {gravity_mps2, {}, {}};
  // Lift is f(speed) (z x v) with f = lift_per_m R omega speed / (2 R|omega| + speed).
  const double rim = air.radius_m * omega_radps;
  const double whole = 2.0 * std::abs(rim) + speed;
  const double f = air.lift_per_m * rim * speed / whole;
  const double f_slope = air.lift_per_m * rim * (2.0 * std::abs(rim) / whole) / whole;
  const double drag = air.drag_per_m * speed;
  const Vector a{gravity_mps2.x - drag * v.x - f * v.y, gravity_mps2.y - drag * v.y + f * v.x};
  const Vector unit{v.x / speed, v.y / speed};
  const Matrix by_velocity{
      -drag - air.drag_per_m * v.x * unit.x - f_slope * v.y * unit.x,
      -air.drag_per_m * v.x * unit.y - f - f_slope * v.y * unit.y,
      -air.drag_per_m * v.y * unit.x + f + f_slope * v.x * unit.x,
      -drag - air.drag_per_m * v.y * unit.y + f_slope * v.x * unit.y,
  };
  return {a, by_velocity * a, by_velocity};
}

Vector Flight::position_at(double t) const {
  const Vector& a = forcing.acceleration_mps2;
  const Vector& j = forcing.jerk_mps3;
  return {position_m.x + t * (velocity_mps.x + t * (a.x / 2.0 + j.x * t / 6.0)),
          position_m.y + t * (velocity_mps.y + t * (a.y / 2.0 + j.y * t / 6.0))};
}

Vector Flight::velocity_at(double t) const {
  const Vector& a = forcing.acceleration_mps2;
  const Vector& j = forcing.jerk_mps3;
  return {velocity_mps.x + t * (a.x + j.x * t / 2.0), velocity_mps.y + t * (a.y + j.y * t / 2.0)};
}

std::optional<double> Flight::time_falling_through_s(double height_m) const {
  const Parabola parabola{position_m, velocity_mps, forcing.acceleration_mps2};
  return corrected(*this, parabola.time_falling_through_s(height_m), height_m);
}

std::optional<double> Flight::time_rising_through_s(double height_m) const {
  const Parabola parabola{position_m, velocity_mps, forcing.acceleration_mps2};
  return corrected(*this, parabola.time_rising_through_s(height_m), height_m);
}

}  // namespace strobe::flight
