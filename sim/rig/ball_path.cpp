#include "sim/rig/ball_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/rig/draws.hpp"

namespace strobe::sim {

namespace {

/// Length of a pulse from which the ball, released while still flattened by y(1), reaches its radius again
/// after `dwell_s` in all: every length of the pulse scales with its duration.
Result<double> pulse_length_s(impact::PulseInput input, double vy_lo_mps, double dwell_s) {
  input.dwell_s = 1.0;
  const auto unit = impact::SinePulse::make(impact::PulseForm::exact, input);
  if (!unit) return fail(std::string(impact::message(unit.error())));
  const double still_flattened_mps = -unit->at_fraction(1.0).y_m;
  return dwell_s / (1.0 + still_flattened_mps / vy_lo_mps);
}

}  // namespace

Throw draw_throw(const Scene& scene, std::uint64_t seed, int shot) {
  const MachineSettings& m = scene.machine;
  const BounceSettings& b = scene.bounce;
  const auto number = static_cast<std::uint64_t>(shot);
  Draws machine(seed, Purpose::machine, number);
  const double speed = std::max(0.5, machine.normal(m.speed_mps, m.speed_sd_mps));
  const double angle = std::clamp(machine.normal(m.angle_rad, m.angle_sd_rad), -1.55, -0.03);

  Throw t;
  t.touchdown = {speed * std::cos(angle), speed * std::sin(angle),
                 machine.normal(m.spin_radps, m.spin_sd_radps)};
  t.lag_s = std::max(0.001, machine.normal(m.lag_s, m.lag_sd_s));
  t.spot_m = machine.normal(0.0, m.spot_sd_m);
  t.equator_rad = machine.uniform() * std::numbers::pi;

  Draws bounce(seed, Purpose::bounce, number);
  const double e_mean = b.e + b.e_slope_spm * (std::abs(t.touchdown.vy_mps) - b.e_speed_mps);
  t.coefficients.e = std::clamp(bounce.normal(e_mean, b.e_sd), 0.05, 0.99);
  const double grip = bounce.normal();
  t.coefficients.mu = std::max(0.0, b.mu + b.mu_sd * grip);
  t.coefficients.e_x = std::clamp(b.ex + b.ex_sd * grip, -1.0, 1.0);
  const double rho = b.offset_grip_correlation;
  const double offset = rho * grip + std::sqrt(1.0 - rho * rho) * bounce.normal();
  t.coefficients.offset_m = std::clamp(b.offset_m + b.offset_sd_m * offset, 0.0, 0.9 * scene.ball.radius_m());
  t.dwell_s = std::clamp(bounce.normal(b.dwell_s, b.dwell_sd_s), 0.5 * b.dwell_s, 1.5 * b.dwell_s);
  return t;
}

BallPath::BallPath(const Scene& scene, const Throw& thrown, const impact::Rebound& rebound,
                   const impact::SinePulse& pulse)
    : thrown_(thrown),
      rebound_(rebound),
      pulse_(pulse),
      radius_m_(scene.ball.radius_m()),
      top_drop_ratio_(scene.bounce.top_drop_ratio),
      approach_(scene, {0.0, radius_m_, thrown.touchdown.vx_mps, thrown.touchdown.vy_mps},
                thrown.touchdown.omega_radps),
      departure_(
          scene,
          {contact_at(thrown.dwell_s).x_m, radius_m_, rebound.lift_off.vx_mps, rebound.lift_off.vy_mps},
          rebound.lift_off.omega_radps) {}

Result<BallPath> BallPath::make(const Scene& scene, const Throw& thrown) {
  const auto rebound = impact::grip(scene.ball, thrown.touchdown, thrown.coefficients);
  if (!rebound) return fail(std::string(impact::message(rebound.error())));
  impact::PulseInput input{.vx_td_mps = thrown.touchdown.vx_mps,
                           .vy_td_mps = thrown.touchdown.vy_mps,
                           .e = thrown.coefficients.e,
                           .impulse_ratio = rebound->impulse_ratio,
                           .dwell_s = thrown.dwell_s,
                           .mass_kg = scene.ball.mass_kg};
  const auto length_s = pulse_length_s(input, rebound->lift_off.vy_mps, thrown.dwell_s);
  if (!length_s) return tl::unexpected(length_s.error());
  input.dwell_s = *length_s;
  const auto pulse = impact::SinePulse::make(impact::PulseForm::exact, input);
  if (!pulse) return fail(std::string(impact::message(pulse.error())));
  return BallPath(scene, thrown, *rebound, *pulse);
}

BallState BallPath::contact_at(double time_s) const {
  const double length_s = pulse_.input().dwell_s;
  const impact::Motion& lo = rebound_.lift_off;
  const impact::PulseState p = pulse_.at_time(std::min(time_s, length_s));
  const double free_s = std::max(0.0, time_s - length_s);
  const double spin_change = lo.omega_radps - thrown_.touchdown.omega_radps;
  // The integral of the impulse's share over time, read off the vertical motion: vy = vy_TD + share·(vy_LO -
  // vy_TD).
  const double vy_td = thrown_.touchdown.vy_mps;
  const double share_s = (p.y_m - vy_td * std::min(time_s, length_s)) / (lo.vy_mps - vy_td);

  BallState s;
  s.vx_mps = p.vx_mps;
  s.vy_mps = p.vy_mps;
  s.omega_radps = thrown_.touchdown.omega_radps + spin_change * p.impulse_fraction;
  s.x_m = p.x_m + lo.vx_mps * free_s;
  const double drop = std::min(0.0, p.y_m + lo.vy_mps * free_s);
  s.y_m = radius_m_ + drop;
  s.top_drop_m = -top_drop_ratio_ * drop;
  s.equator_rad =
      thrown_.equator_rad + thrown_.touchdown.omega_radps * time_s + spin_change * (share_s + free_s);
  return s;
}

BallState BallPath::at(double time_s) const {
  if (time_s > 0.0 && time_s < thrown_.dwell_s) return contact_at(time_s);
  const bool rebounding = time_s > 0.0;
  const double flight_s = rebounding ? time_s - thrown_.dwell_s : time_s;
  const FlightState state = (rebounding ? departure_ : approach_).at(flight_s);
  const double equator = rebounding ? contact_at(thrown_.dwell_s).equator_rad : thrown_.equator_rad;
  const double omega = (rebounding ? rebound_.lift_off : thrown_.touchdown).omega_radps;
  return {.x_m = state.x_m,
          .y_m = state.y_m,
          .vx_mps = state.vx_mps,
          .vy_mps = state.vy_mps,
          .omega_radps = omega,
          .equator_rad = equator + omega * flight_s};
}

std::optional<double> BallPath::time_at_distance_s(double distance_m) const {
  return approach_.time_back_at_x_s(-distance_m);
}

}  // namespace strobe::sim
