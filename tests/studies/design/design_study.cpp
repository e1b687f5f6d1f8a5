#include "tests/studies/design/design_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

#include "common/flight/aerodynamics.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/units/angles.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "host/config/digitize_times.hpp"
#include "host/session/shot.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::studies {
namespace {

using reduction::kQuantityCount;
using reduction::Quantity;

/// Of both sensors' stamps of a flash, the mean.
constexpr double kStampSd_s = 0.15e-6;
/// The simulated lamps recharge in 1.4 ms.
constexpr double kShortestPeriod_s = 1.5e-3;

/// Another spin, say; counted apart.
constexpr double kGross = 10.0;

class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) {
    std::seed_seq words{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(stream)};
    engine_.seed(words);
  }
  double uniform(double from, double to) { return std::uniform_real_distribution(from, to)(engine_); }
  double by_factor(double from, double to) { return from * std::pow(to / from, uniform(0.0, 1.0)); }
  double normal() { return normal_(engine_); }
  bool coin() { return uniform(0.0, 1.0) < 0.5; }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

void draw_balls(Random& random, sim::Scene& scene) {
  sim::MachineSettings& m = scene.machine;
  m.speed_mps = random.by_factor(3.0, 45.0);
  m.angle_rad = -radians(random.uniform(10.0, 90.0));
  m.spin_radps = random.uniform(-600.0, 600.0);
  m.speed_sd_mps = random.uniform(0.005, 0.02) * m.speed_mps;
  m.angle_sd_rad = radians(random.uniform(0.1, 0.5));
  m.spin_sd_radps = random.uniform(1.0, 5.0);
  m.lag_sd_s = random.uniform(0.5e-3, 3e-3);
  sim::BounceSettings& b = scene.bounce;
  b.e = random.uniform(0.65, 0.85);
  b.e_sd = random.uniform(0.005, 0.02);
  b.e_slope_spm = 0.0;
  b.e_speed_mps = m.speed_mps * std::sin(-m.angle_rad);
  b.mu = random.uniform(0.4, 0.7);
  b.mu_sd = 0.01;
  b.dwell_s = random.uniform(4.2e-3, 5.5e-3);
  b.dwell_sd_s = 0.1e-3;
}

host::ExpectedBall expected_of(const sim::Scene& s) {
  host::ExpectedBall b;
  b.speed_mps = {s.machine.speed_mps, s.machine.speed_sd_mps};
  b.angle_rad = {s.machine.angle_rad, s.machine.angle_sd_rad};
  b.spin_radps = {s.machine.spin_radps, s.machine.spin_sd_radps};
  b.e = {s.bounce.e, s.bounce.e_sd};
  b.mu = {s.bounce.mu, s.bounce.mu_sd};
  b.dwell_s = {s.bounce.dwell_s, s.bounce.dwell_sd_s};
  b.ball = s.ball;
  b.air_density_kgpm3 = flight::air_density_kgpm3(s.air.temperature_c);
  return b;
}

/// The camera's view with the discs at its edges.
void set_view(const sim::Scene& s, host::SetUp& set_up) {
  const double radius_m = 0.5 * s.ball.diameter_m, scale = s.camera.px_per_m;
  set_up.width_px = 2.0 * (s.camera.half_width_m + radius_m) * scale;
  set_up.touchdown_x_px = 0.5 * set_up.width_px;
  set_up.surface_y_px = radius_m * scale;
  set_up.height_px = set_up.surface_y_px + (s.camera.height_m + radius_m) * scale;
}

struct Errors {
  double scale = 0.0, ball_diameter_m = 0.0, drag_coefficient = 0.0, lift_factor = 1.0, spin_decay_per_m = 0.0;
};

Errors drawn_errors(const DrawnDesign& d, Random& random) {
  Errors e;
  e.scale = d.scale_sd * random.normal();
  e.ball_diameter_m = d.design.set_up.ball_diameter_sd_m * random.normal();
  e.drag_coefficient = flight::AirLaw{}.drag_coefficient + flight::AirLaw{}.drag_coefficient_sd * random.normal();
  e.lift_factor = std::max(0.0, 1.0 + flight::AirLaw{}.lift_share_sd * random.normal());
  e.spin_decay_per_m = std::max(0.0, flight::AirLaw{}.spin_decay_per_m + flight::AirLaw{}.spin_decay_sd_per_m * random.normal());
  return e;
}

sim::SimulatedShot shot_of(const DrawnDesign& d, const Errors& e, std::uint64_t seed, int number) {
  sim::Scene scene = d.scene;
  scene.ball.diameter_m += e.ball_diameter_m;
  scene.air.drag_coefficient = e.drag_coefficient;
  scene.air.lift_factor = e.lift_factor;
  scene.air.spin_decay_per_m = e.spin_decay_per_m;
  sim::ShootSettings settings;
  for (const double s : host::expected_train(d.design.plan.shot(), d.design.set_up, d.design.ball).flash_s)
    settings.train.push_back(from_seconds(s));
  auto shooter = sim::Shooter::make(scene, seed, sim::Model::full(), settings);
  assert(shooter);
  return shooter->shoot(number);
}

/// As the laboratory has it: with the stated ball and scale.
reduction::Frame stated(reduction::Frame frame, const DrawnDesign& d, const Errors& e) {
  frame.ball_diameter_m = d.scene.ball.diameter_m;
  frame.ball_diameter_sd_m = d.design.set_up.ball_diameter_sd_m;
  frame.px_per_m.reset();
  frame.px_per_m_sd.reset();
  if (d.calibrated) {
    frame.px_per_m = d.scene.camera.px_per_m * (1.0 + e.scale);
    frame.px_per_m_sd = d.scene.camera.px_per_m * d.scale_sd;
  }
  std::erase_if(frame.images, [](const reduction::BallImage& image) { return image.leg == Leg::contact; });
  for (reduction::BallImage& image : frame.images) image.time_sd_s = kStampSd_s;
  return frame;
}

/// A number as the ball is seen that was taken to travel the other way: a drop may go either.
double unmirrored(Quantity q, double value) {
  switch (q) {
    case Quantity::theta_in_deg:
      return -180.0 - value;
    case Quantity::theta_out_deg:
      return 180.0 - value;
    case Quantity::vx_td_mps:
    case Quantity::omega_td_radps:
    case Quantity::vx_lo_mps:
    case Quantity::omega_lo_radps:
    case Quantity::slip_lo_mps:
    case Quantity::mu:
    case Quantity::dwell_distance_cm:
      return -value;
    default:
      return value;
  }
}

}  // namespace

DrawnDesign drawn_design(const sim::Scene& base, std::uint64_t seed, int number) {
  Random random(seed, static_cast<std::uint64_t>(number));
  DrawnDesign d;
  d.scene = base;
  draw_balls(random, d.scene);
  d.scene.camera.px_per_m = random.by_factor(800.0, 6000.0);
  d.scene.tablet.centre_sd_m = random.by_factor(0.03, 2.0) / d.scene.camera.px_per_m;
  d.scene.tablet.equator_sd_rad = radians(random.by_factor(0.03, 1.0));
  d.calibrated = random.coin();
  d.scale_sd = random.by_factor(0.0002, 0.005);

  d.rig.camera.px_per_m = d.scene.camera.px_per_m;
  if (d.calibrated) d.rig.camera.px_per_m_sd = d.scale_sd * d.scene.camera.px_per_m;
  d.rig.ball.diameter_m = d.scene.ball.diameter_m;
  d.rig.ball.mass_kg = d.scene.ball.mass_kg;
  d.rig.ball.diameter_sd_m = random.by_factor(0.05e-3, 0.8e-3);
  d.rig.analysis.machine_lag_sd_s = d.scene.machine.lag_sd_s;
  d.rig.analysis.flash_time_sd_s = kStampSd_s;
  d.rig.ball.fastest_spin_radps = sim::known_fastest_spin_radps(d.scene);
  d.rig.record["temperature_c"] = fmt::format("{}", d.scene.air.temperature_c);
  const auto set_up = host::set_up_of(d.rig);
  assert(set_up);
  d.design.set_up = *set_up;
  host::SetUp& s = d.design.set_up;
  set_view(d.scene, s);
  s.measured_by = host::MeasuredBy::hand;
  s.hand_centre_sd_m = d.scene.tablet.centre_sd_m;
  s.hand_equator_sd_rad = d.scene.tablet.equator_sd_rad;
  s.spot_sd_m = d.scene.machine.spot_sd_m;
  s.surface_angle_rad = d.scene.surface_angle_rad;
  d.design.ball = expected_of(d.scene);

  const double leg_s = std::min(d.scene.camera.half_width_m / std::cos(d.scene.machine.angle_rad),
                                d.scene.camera.height_m / std::sin(-d.scene.machine.angle_rad)) / d.scene.machine.speed_mps;
  host::PlanFile plan;
  plan.even.period = microseconds{std::llround(1e6 * std::clamp(leg_s / random.uniform(3.0, 12.0), kShortestPeriod_s, 30e-3))};
  // The balls come in the middle of the train, as sim::Shooter has it.
  const double impact_s = leg_s + 5.0 * s.arrival_sd_s + 2.0 * to_seconds(plan.even.period);
  plan.even.exposure = from_seconds(2.0 * impact_s);
  plan.spacing = random.coin() ? host::Spacing::coded : host::Spacing::even;
  d.design.plan = host::spaced_plan(plan, d.rig, true).plan;
  const auto flashes = host::expected_train(d.design.plan.shot(), s, d.design.ball).flash_s;
  d.design.plan.even.impact_at = from_seconds(0.5 * flashes.back());
  d.scene.name = fmt::format("{:.1f} m/s {:.0f} deg {:.0f} rad/s, {:.0f} px/m, {:.2f} px, {} {:.2g} ms, {}",
                             d.scene.machine.speed_mps, degrees(d.scene.machine.angle_rad), d.scene.machine.spin_radps,
                             d.scene.camera.px_per_m, d.scene.tablet.centre_sd_m * d.scene.camera.px_per_m,
                             d.design.plan.intervals.empty() ? "even" : "coded", 1e3 * to_seconds(plan.even.period),
                             d.calibrated ? fmt::format("scale {:.2g} %", 100.0 * d.scale_sd) : "scale from the ball");
  return d;
}

DesignOutcome foretold_and_found(const DrawnDesign& d, int shots, std::uint64_t seed) {
  DesignOutcome outcome{.name = d.scene.name};
  const auto prediction = host::predict(d.design, {.balls = 256, .budgets = 0, .match = false});
  if (!prediction) {
    outcome.name += ": " + prediction.error().message;
    return outcome;
  }
  outcome.predicted_readable = prediction->readable_share();
  Random random(seed, 0x5eed);
  std::array<double, kQuantityCount> squares{}, stated_squares{};
  int counted = 0;
  for (int shot = 1; shot <= shots; ++shot) {
    const Errors errors = drawn_errors(d, random);
    const sim::SimulatedShot simulated = shot_of(d, errors, seed, shot);
    const auto readout = reduction::reduce(stated(simulated.frame, d, errors), reduction::Estimator::best);
    if (!readout || host::rejection_reason(*readout)) continue;
    ++counted;
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (!readout->value[q] || !simulated.truth[q] || !prediction->quantities[i]) continue;
      const double value = readout->mirrored ? unmirrored(q, *readout->value[q]) : *readout->value[q];
      const double error = value - *simulated.truth[q];
      if (std::abs(error) > kGross * prediction->quantities[i]->shot_sd) {
        ++outcome.quantities[i].gross;
        continue;
      }
      squares[i] += error * error;
      stated_squares[i] += std::pow(reduction::total_sd(*readout, q).value_or(0.0), 2);
      ++outcome.quantities[i].shots;
    }
  }
  outcome.readable = static_cast<double>(counted) / shots;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    Foretold& f = outcome.quantities[i];
    const auto& q = prediction->quantities[i];
    if (!q || f.shots == 0) f.shots = 0;
    if (f.shots == 0) continue;
    f.predicted = q->shot_sd;
    f.error = std::sqrt(squares[i] / f.shots);
    f.stated = std::sqrt(stated_squares[i] / f.shots);
  }
  return outcome;
}

}  // namespace strobe::studies
