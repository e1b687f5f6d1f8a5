#include "sim/motion/flight.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/flight/gravity.hpp"

namespace strobe::sim {

namespace {

/// Velocities change at rates of q·|v|, at most 3 per second for a tennis ball of 60 m/s in usual air, so
/// that a step of the classical Runge-Kutta method errs by less than v·(2e-3·3)^5/120 or 1e-13 of v.
constexpr double kFlightStep_s = 2e-3;
constexpr double kLongestFlight_s = 60.0;
/// With rates of 25 per second, of a fast ball in air ten times as dense, a step errs by 20 um.
constexpr double kRoughStep_s = 1e-2;

double steps_to(double time_s, double step_s = kFlightStep_s) { return std::ceil(std::abs(time_s) / step_s); }

/// A FlightState of one instant (double) or of several side by side (an array).
template <typename Real>
struct Course {
  Real x, y, vx, vy, omega, rotation;
};

using Side = Eigen::Array<double, 4, 1>;

// 0 over 0 is none of the ball's speeds.
constexpr double kMinSpeed_mps = std::numeric_limits<double>::min();
double at_least_min(double speed_mps) { return std::max(speed_mps, kMinSpeed_mps); }
Side at_least_min(const Side& speed_mps) { return speed_mps.max(kMinSpeed_mps); }

// Inlined: calls would pass arrays of four through memory, at twice the time.

/// What forces act on, and their accelerations.
template <typename Real>
struct Speeds {
  Real vx, vy, omega;
};

template <typename Real, typename Law>
[[gnu::always_inline]] inline Speeds<Real> slope(const Law& law, const Speeds<Real>& s) {
  using std::abs, std::sqrt;
  const Real v = sqrt(s.vx * s.vx + s.vy * s.vy);
  const Real drag = law.drag_pm * v;
  const Real rim = law.radius_m * s.omega;
  const Real together = law.lift_slope * abs(rim) + law.lift_offset * v;
  const Real lift = law.lift_pm * v * rim / at_least_min(together);
  return {law.gravity_x_mps2 - drag * s.vx - lift * s.vy, law.gravity_y_mps2 - drag * s.vy + lift * s.vx,
          -law.decay_pm * v * s.omega};
}

template <typename Real>
[[gnu::always_inline]] inline Speeds<Real> plus(const Speeds<Real>& s, const Speeds<Real>& slope,
                                                const Real& h) {
  return {s.vx + h * slope.vx, s.vy + h * slope.vy, s.omega + h * slope.omega};
}

/// Each part of a step after the other.
template <typename Real>
[[gnu::always_inline]] inline void add(Course<Real>& to, const Speeds<Real>& speeds,
                                       const Speeds<Real>& slope, const Real& h) {
  to.x += h * speeds.vx;
  to.y += h * speeds.vy;
  to.rotation += h * speeds.omega;
  to.vx += h * slope.vx;
  to.vy += h * slope.vy;
  to.omega += h * slope.omega;
}

template <typename Real, typename Law>
void take_step(const Law& law, Course<Real>& s, const Real& h) {
  const Real half = 0.5 * h, third = h / 3.0, sixth = h / 6.0;
  const Speeds<Real> first{s.vx, s.vy, s.omega};
  const Speeds<Real> a = slope(law, first);
  add(s, first, a, sixth);
  const Speeds<Real> second = plus(first, a, half), b = slope(law, second);
  add(s, second, b, third);
  const Speeds<Real> third_speeds = plus(first, b, half), c = slope(law, third_speeds);
  add(s, third_speeds, c, third);
  const Speeds<Real> last = plus(first, c, h), d = slope(law, last);
  add(s, last, d, sixth);
}

double density_kgpm3(const AirSettings& air) {
  constexpr double kPressure_Pa = 101325.0;
  constexpr double kDryAir_JpkgK = 287.05;
  return air.density_kgpm3 >= 0.0 ? air.density_kgpm3
                                  : kPressure_Pa / (kDryAir_JpkgK * (air.temperature_c + 273.15));
}

}  // namespace

Flight::Flight(const Scene& scene, const FlightState& start, double omega_radps, const Model& model)
    : start_(start) {
  start_.omega_radps = omega_radps;
  start_.rotation_rad = 0.0;
  law_.radius_m = scene.ball.radius_m();
  law_.decay_pm = model.has(Effect::spin_decay) ? scene.air.spin_decay_per_m : 0.0;
  const double area = std::numbers::pi * law_.radius_m * law_.radius_m;
  const double q = density_kgpm3(scene.air) * area / (2.0 * scene.ball.mass_kg);
  law_.drag_pm = model.has(Effect::drag) ? q * scene.air.drag_coefficient : 0.0;
  law_.lift_offset = scene.air.lift_offset;
  law_.lift_slope = scene.air.lift_slope;
  law_.lift_pm = model.has(Effect::magnus) && scene.air.lift ? scene.air.lift_factor * q : 0.0;
  parabola_ = law_.drag_pm == 0.0 && law_.lift_pm == 0.0 && law_.decay_pm == 0.0;
  if (!model.has(Effect::gravity)) return;
  law_.gravity_x_mps2 = -flight::kStandardGravity_mps2 * std::sin(scene.surface_angle_rad);
  law_.gravity_y_mps2 = -flight::kStandardGravity_mps2 * std::cos(scene.surface_angle_rad);
}

FlightState Flight::fall(double time_s) const {
  const double x = start_.vx_mps + 0.5 * law_.gravity_x_mps2 * time_s;
  const double y = start_.vy_mps + 0.5 * law_.gravity_y_mps2 * time_s;
  return {start_.x_m + x * time_s,
          start_.y_m + y * time_s,
          start_.vx_mps + law_.gravity_x_mps2 * time_s,
          start_.vy_mps + law_.gravity_y_mps2 * time_s,
          start_.omega_radps,
          start_.omega_radps * time_s,
          start_.z_m + start_.vz_mps * time_s,
          start_.vz_mps};
}

FlightState Flight::step(const FlightState& s, double h_s) const {
  if (spatial_) return spatial_step(s, h_s);
  Course<double> at{s.x_m, s.y_m, s.vx_mps, s.vy_mps, s.omega_radps, s.rotation_rad};
  take_step(law_, at, h_s);
  return {at.x, at.y, at.vx, at.vy, at.omega, at.rotation};
}

FlightState Flight::at(double time_s) const { return at(time_s, steps_to(time_s)); }

FlightState Flight::roughly_at(double time_s) const { return at(time_s, steps_to(time_s, kRoughStep_s)); }

FlightState Flight::at(double time_s, double steps) const {
  if (parabola_) return fall(time_s);
  FlightState s = start_;
  for (int i = 0; i < static_cast<int>(steps); ++i) s = step(s, time_s / steps);
  return s;
}

std::array<FlightState, 4> Flight::at(const Instants& time_s) const {
  const double steps = steps_to(time_s[0]);
  const bool alike =
      std::ranges::all_of(time_s, [steps](double each_s) { return steps_to(each_s) == steps; });
  if (parabola_ || spatial_ || !alike || steps == 0.0)
    return {at(time_s[0]), at(time_s[1]), at(time_s[2]), at(time_s[3])};
  const Side h = Eigen::Map<const Side>(time_s.data()) / steps;
  const auto each = [](double value) -> Side { return Side::Constant(value); };
  Course<Side> s{each(start_.x_m),    each(start_.y_m),         each(start_.vx_mps),
                 each(start_.vy_mps), each(start_.omega_radps), each(start_.rotation_rad)};
  for (int i = 0; i < static_cast<int>(steps); ++i) take_step(law_, s, h);
  std::array<FlightState, 4> out;
  for (std::size_t k = 0; k < out.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    out[k] = {s.x[i], s.y[i], s.vx[i], s.vy[i], s.omega[i], s.rotation[i]};
  }
  return out;
}

std::optional<double> Flight::time_back_down_s() const {
  constexpr double kScan_s = 1e-3, kLongestBounce_s = 2.0;
  constexpr double kUnsure_m = 1e-9;  // far more than the steps' errors
  const double level_m = start_.y_m;
  FlightState running = start_;
  double above_s = 0.0, below_s = 0.0;
  for (;;) {
    above_s = below_s;
    below_s += kScan_s;
    if (below_s > kLongestBounce_s) return std::nullopt;
    running = parabola_ ? fall(below_s) : step(running, kScan_s);
    const bool unsure = std::abs(running.y_m - level_m) < kUnsure_m;
    if ((unsure ? at(below_s).y_m : running.y_m) < level_m) break;
  }
  constexpr int kHalvings = 50;  // of a millisecond: to a double's last digits
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_s = 0.5 * (above_s + below_s);
    if (middle_s == above_s || middle_s == below_s) break;
    (at(middle_s).y_m >= level_m ? above_s : below_s) = middle_s;
  }
  return above_s;
}

std::optional<double> Flight::time_back_at_x_s(double x_m) const {
  FlightState s = start_;
  for (int steps = 0; s.x_m > x_m;) {
    s = step(s, -kFlightStep_s);
    ++steps;
    if (!(s.vx_mps > 0.0) || steps * kFlightStep_s > kLongestFlight_s) return std::nullopt;
    if (s.x_m > x_m) continue;
    // Newton from the last step's end, where the path is nearly straight.
    double rest_s = 0.0;
    for (int i = 0; i < 4; ++i) {
      const FlightState near = step(s, rest_s);
      rest_s -= (near.x_m - x_m) / near.vx_mps;
    }
    return rest_s - steps * kFlightStep_s;
  }
  return 0.0;
}

namespace {

/// From rest at the upper end, forward in time or backward.
VerticalFlight through(const Scene& scene, double height_m, double forward) {
  Scene level = scene;
  level.surface_angle_rad = 0.0;
  const Flight flight(level, {.y_m = height_m}, 0.0);
  const auto above = [&](double time_s) { return flight.at(forward * time_s).y_m > 0.0; };
  double early_s = 0.0, late_s = std::sqrt(2.0 * height_m / 9.8);
  while (above(late_s) && late_s < 60.0) late_s *= 1.5;
  for (int round = 0; round < 60; ++round) {
    const double middle_s = 0.5 * (early_s + late_s);
    (above(middle_s) ? early_s : late_s) = middle_s;
  }
  return {std::abs(flight.at(forward * late_s).vy_mps), late_s};
}

}  // namespace

VerticalFlight falling(const Scene& scene, double height_m) { return through(scene, height_m, 1.0); }

VerticalFlight rising(const Scene& scene, double height_m) { return through(scene, height_m, -1.0); }

}  // namespace strobe::sim
