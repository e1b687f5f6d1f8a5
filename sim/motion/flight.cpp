#include "sim/motion/flight.hpp"

#include <cmath>
#include <numbers>

#include "common/flight/gravity.hpp"

namespace strobe::sim {

namespace {

/// Velocities change at rates of q·|v|, at most 3 per second for a tennis ball of 60 m/s in usual air, so
/// that a step of the classical Runge-Kutta method errs by less than v·(2e-3·3)^5/120 or 1e-13 of v.
constexpr double kStep_s = 2e-3;
constexpr double kLongest_s = 60.0;

FlightState plus(const FlightState& s, const FlightState& slope, double h_s) {
  return {s.x_m + h_s * slope.x_m,
          s.y_m + h_s * slope.y_m,
          s.vx_mps + h_s * slope.vx_mps,
          s.vy_mps + h_s * slope.vy_mps,
          s.omega_radps + h_s * slope.omega_radps,
          s.rotation_rad + h_s * slope.rotation_rad};
}

double density_kgpm3(const AirSettings& air) {
  constexpr double kPressure_Pa = 101325.0;
  constexpr double kDryAir_JpkgK = 287.05;
  return air.density_kgpm3 >= 0.0 ? air.density_kgpm3
                                  : kPressure_Pa / (kDryAir_JpkgK * (air.temperature_c + 273.15));
}

}  // namespace

Flight::Flight(const Scene& scene, const FlightState& start, double omega_radps, const Model& model)
    : start_(start),
      radius_m_(scene.ball.radius_m()),
      decay_pm_(model.has(Effect::spin_decay) ? scene.air.spin_decay_per_m : 0.0),
      gravity_x_mps2_(0.0),
      gravity_y_mps2_(0.0) {
  start_.omega_radps = omega_radps;
  start_.rotation_rad = 0.0;
  const double area = std::numbers::pi * radius_m_ * radius_m_;
  const double q = density_kgpm3(scene.air) * area / (2.0 * scene.ball.mass_kg);
  drag_pm_ = model.has(Effect::drag) ? q * scene.air.drag_coefficient : 0.0;
  lift_pm_ = model.has(Effect::magnus) && scene.air.lift ? q : 0.0;
  parabola_ = drag_pm_ == 0.0 && lift_pm_ == 0.0 && decay_pm_ == 0.0;
  if (!model.has(Effect::gravity)) return;
  gravity_x_mps2_ = -flight::kStandardGravity_mps2 * std::sin(scene.surface_angle_rad);
  gravity_y_mps2_ = -flight::kStandardGravity_mps2 * std::cos(scene.surface_angle_rad);
}

FlightState Flight::slope(const FlightState& s) const {
  const double v = std::sqrt(s.vx_mps * s.vx_mps + s.vy_mps * s.vy_mps);
  const double drag = drag_pm_ * v;
  const double rim = radius_m_ * s.omega_radps;
  const double lift = v > 0.0 ? lift_pm_ * v * rim / (2.0 * std::abs(rim) + v) : 0.0;
  return {s.vx_mps,
          s.vy_mps,
          gravity_x_mps2_ - drag * s.vx_mps - lift * s.vy_mps,
          gravity_y_mps2_ - drag * s.vy_mps + lift * s.vx_mps,
          -decay_pm_ * v * s.omega_radps,
          s.omega_radps};
}

FlightState Flight::fall(double time_s) const {
  const double x = start_.vx_mps + 0.5 * gravity_x_mps2_ * time_s;
  const double y = start_.vy_mps + 0.5 * gravity_y_mps2_ * time_s;
  return {start_.x_m + x * time_s,
          start_.y_m + y * time_s,
          start_.vx_mps + gravity_x_mps2_ * time_s,
          start_.vy_mps + gravity_y_mps2_ * time_s,
          start_.omega_radps,
          start_.omega_radps * time_s};
}

FlightState Flight::step(const FlightState& s, double h_s) const {
  const FlightState a = slope(s);
  const FlightState b = slope(plus(s, a, 0.5 * h_s));
  const FlightState c = slope(plus(s, b, 0.5 * h_s));
  const FlightState d = slope(plus(s, c, h_s));
  FlightState next = plus(s, a, h_s / 6.0);
  next = plus(next, b, h_s / 3.0);
  next = plus(next, c, h_s / 3.0);
  return plus(next, d, h_s / 6.0);
}

FlightState Flight::at(double time_s) const {
  if (parabola_) return fall(time_s);
  const double steps = std::ceil(std::abs(time_s) / kStep_s);
  FlightState s = start_;
  for (int i = 0; i < static_cast<int>(steps); ++i) s = step(s, time_s / steps);
  return s;
}

std::optional<double> Flight::time_back_at_x_s(double x_m) const {
  FlightState s = start_;
  for (int steps = 0; s.x_m > x_m;) {
    s = step(s, -kStep_s);
    ++steps;
    if (!(s.vx_mps > 0.0) || steps * kStep_s > kLongest_s) return std::nullopt;
    if (s.x_m > x_m) continue;
    // Newton from the last step's end, where the path is nearly straight.
    double rest_s = 0.0;
    for (int i = 0; i < 4; ++i) {
      const FlightState near = step(s, rest_s);
      rest_s -= (near.x_m - x_m) / near.vx_mps;
    }
    return rest_s - steps * kStep_s;
  }
  return 0.0;
}

}  // namespace strobe::sim
