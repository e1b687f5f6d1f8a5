// Models of free flight against the equation of motion in long double.
#include <fmt/format.h>

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "common/flight/aerodynamics.hpp"
#include "sim/motion/flight.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/studies/trade/stopwatch.hpp"
#include "tests/studies/trade/studies.hpp"

namespace strobe::studies::trade {

namespace {

using Eigen::Vector2d;

/// Five images at 3 ms: from the first of a leg to the last.
constexpr double kLeg_s = 12e-3;

struct Start {
  sim::Scene scene;
  Vector2d velocity_mps = Vector2d::Zero();
  double omega_radps = 0.0;
};

struct End {
  Vector2d position_m = Vector2d::Zero(), velocity_mps = Vector2d::Zero();
};

struct KnownFlight {
  Start start;
  End end;
};

End exact_end(const Start& s, int steps) {
  using Real = long double;
  using State = std::array<Real, 5>;  // x, y, vx, vy, omega
  const sim::Scene& scene = s.scene;
  const Real radius = scene.ball.radius_m();
  const Real q = Real(scene.air.density_kgpm3) * boost::math::constants::pi<Real>() * radius * radius /
                 (2 * Real(scene.ball.mass_kg));
  const Real gravity = flight::kStandardGravity_mps2, incline = scene.surface_angle_rad;
  const auto slope = [&](const State& z, State& d, Real) {
    const Real v = std::sqrt(z[2] * z[2] + z[3] * z[3]), rim = radius * z[4];
    const Real drag = q * Real(scene.air.drag_coefficient) * v;
    const Real lift = q * v * rim / (2 * std::abs(rim) + v);
    d = {z[2], z[3], -gravity * std::sin(incline) - drag * z[2] - lift * z[3],
         -gravity * std::cos(incline) - drag * z[3] + lift * z[2],
         -Real(scene.air.spin_decay_per_m) * v * z[4]};
  };
  boost::numeric::odeint::runge_kutta_fehlberg78<State, Real, State, Real,
                                                 boost::numeric::odeint::array_algebra>
      stepper;
  State z{0, 0, s.velocity_mps.x(), s.velocity_mps.y(), s.omega_radps};
  const Real h = Real(kLeg_s) / steps;
  for (int i = 0; i < steps; ++i) stepper.do_step(slope, z, h * i, h);
  return {{static_cast<double>(z[0]), static_cast<double>(z[1])},
          {static_cast<double>(z[2]), static_cast<double>(z[3])}};
}

double difference(const Start& s, const End& got, const End& want) {
  const double speed = std::hypot(s.velocity_mps.x(), s.velocity_mps.y());
  const double place = (got.position_m - want.position_m).norm();
  const double velocity = (got.velocity_mps - want.velocity_mps).norm();
  return std::max(place / kLeg_s, velocity) / speed;
}

Start start_of(double speed_mps, double angle_rad, double omega_radps) {
  Start s{.scene = {},
          .velocity_mps = {speed_mps * std::cos(angle_rad), speed_mps * std::sin(angle_rad)},
          .omega_radps = omega_radps};
  s.scene.air.density_kgpm3 = flight::kAirDensity_kgpm3;
  return s;
}

std::vector<KnownFlight> practical_flights(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<KnownFlight> flights;
  for (int i = 0; i < count; ++i) {
    const double speed = std::exp(between(std::log(5.0), std::log(60.0)));
    const double most = std::min(600.0, speed / (0.5 * ball::kThesisDiameter_m));
    const double angle = between(-85.0, 85.0) * std::numbers::pi / 180.0;
    Start s = start_of(speed, angle, between(-most, most));
    s.scene.surface_angle_rad = between(-5.0, 5.0) * std::numbers::pi / 180.0;
    s.scene.air.density_kgpm3 = between(0.9, 1.3);
    flights.push_back({s, exact_end(s, 32)});
  }
  return flights;
}

std::vector<KnownFlight> thesis_flights() {
  std::vector<KnownFlight> flights;
  for (const test::Bounce& b : test::thesis_bounces())
    for (const Start& s : {start_of(std::hypot(b.vx_td, b.vy_td), std::atan2(b.vy_td, b.vx_td), b.omega_td),
                           start_of(std::hypot(b.vx_lo, b.vy_lo), std::atan2(b.vy_lo, b.vx_lo), b.omega_lo)})
      flights.push_back({s, exact_end(s, 32)});
  return flights;
}

flight::Forcing forcing_of(const Start& s, flight::Effects effects) {
  const auto air = flight::aerodynamics(s.scene.ball, s.scene.air.density_kgpm3, effects);
  return flight::forcing(air, flight::gravity_mps2(s.scene.surface_angle_rad), s.velocity_mps, s.omega_radps);
}

End straight(const Start& s) { return {s.velocity_mps * kLeg_s, s.velocity_mps}; }

End parabola(const Start& s, flight::Effects effects) {
  const flight::Parabola path{Vector2d::Zero(), s.velocity_mps, forcing_of(s, effects).acceleration_mps2};
  return {path.position_at(kLeg_s), path.velocity_at(kLeg_s)};
}

End gravity_alone(const Start& s) {
  const flight::Parabola path{Vector2d::Zero(), s.velocity_mps,
                              flight::gravity_mps2(s.scene.surface_angle_rad)};
  return {path.position_at(kLeg_s), path.velocity_at(kLeg_s)};
}

End series(const Start& s) {
  const flight::Flight path{Vector2d::Zero(), s.velocity_mps, forcing_of(s, {})};
  return {path.position_at(kLeg_s), path.velocity_at(kLeg_s)};
}

End integrated(const Start& s) {
  const sim::Flight path(s.scene, {0.0, 0.0, s.velocity_mps.x(), s.velocity_mps.y()}, s.omega_radps);
  const sim::FlightState end = path.at(kLeg_s);
  return {{end.x_m, end.y_m}, {end.vx_mps, end.vy_mps}};
}

Error error_over(const std::vector<KnownFlight>& set, const auto& fly) {
  Tally tally;
  for (const KnownFlight& k : set) tally.add(difference(k.start, fly(k.start), k.end));
  return tally.error();
}

}  // namespace

Study flight_study(const Effort& effort) {
  const auto practical = practical_flights(effort.scenes, effort.seed);
  const auto thesis = thesis_flights();
  Study study{
      .name = "flight",
      .title = "Free flight over a leg of 12 ms",
      .what = fmt::format(
          "{} scenes: 5 to 60 m/s, any direction, |R omega| up to the speed and 600 rad/s, plate within "
          "5 degrees, air .9-1.3 kg/m3, spin decaying; norm: the larger of the velocity's error over "
          "the speed and the place's over the way; reference: Boost.odeint, long double",
          practical.size()),
      .unit = "of v and v*t"};
  for (std::size_t i = 0; i < std::min<std::size_t>(practical.size(), 40); ++i)
    study.reference = std::max(
        study.reference, difference(practical[i].start, exact_end(practical[i].start, 16), practical[i].end));
  const auto add = [&](const char* method, Source source, const auto& fly) {
    Row row{.method = method, .parameter = "", .source = source};
    row.practical = error_over(practical, fly);
    row.thesis = error_over(thesis, fly);
    row.cost_us = least_cost_us(effort.repetitions, practical.size(),
                                [&](std::size_t i) { keep(fly(practical[i].start)); });
    study.rows.push_back(row);
  };
  add("straight", Source::model, straight);
  add("parabola", Source::model, gravity_alone);
  add("parabola_drag", Source::model,
      [](const Start& s) { return parabola(s, {.gravity = true, .drag = true, .magnus = false}); });
  add("parabola_drag_magnus", Source::model, [](const Start& s) { return parabola(s, {}); });
  add("series", Source::model, series);
  add("rk4", Source::numerical, integrated);
  return study;
}

}  // namespace strobe::studies::trade
