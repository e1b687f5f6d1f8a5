#include "host/bounces/balance.hpp"

#include <cmath>

namespace strobe::bounces {

namespace {

impact::Observation observation_of(const published::Bounce& b, double along_mps) {
  const double e = *b.restitution();
  return {.name = b.name,
          .spin = {},
          .series = {},
          .touchdown = {b.vx_td_mps.value, b.vy_td_mps.value, b.omega_td_radps.value},
          .touchdown_sd = {b.vx_td_mps.sd, b.vy_td_mps.sd, b.omega_td_radps.sd},
          .lift_off = {b.vx_lo_mps->value - along_mps, b.vy_lo_mps->value, b.omega_lo_radps.value},
          .lift_off_sd = {b.vx_lo_mps->sd, b.vy_lo_mps->sd, b.omega_lo_radps.sd},
          .e = e,
          .e_sd = e * std::hypot(b.vy_td_mps.sd / b.vy_td_mps.value, b.vy_lo_mps->sd / b.vy_lo_mps->value)};
}

}  // namespace

std::optional<Balance> balance_of(const Case& c, bool with_weight) {
  const published::Bounce& b = c.bounce;
  if (!b.vx_lo_mps) return std::nullopt;
  const double radius_m = c.ball.diameter_m / 2.0;
  const double along_mps2 = with_weight ? weight_of(b).along_mps2 : 0.0;
  const double change_mps = b.vx_lo_mps->value - b.vx_td_mps.value - along_mps2 * c.dwell_s;
  const double spin_mps = radius_m * (b.omega_lo_radps.value - b.omega_td_radps.value);
  if (spin_mps == 0.0) return std::nullopt;
  const auto friction = impact::rolling_friction(
      observation_of(b, along_mps2 * c.dwell_s),
      {.diameter_m = c.ball.diameter_m, .mass_kg = c.ball.mass_kg, .alpha = c.ball.alpha.value},
      c.ball.alpha.sd);
  if (!friction) return std::nullopt;
  const double alpha = change_mps / spin_mps;
  const double weight_sd_mps = along_mps2 * kDwellSd_s;
  const double change_sd = std::hypot(b.vx_lo_mps->sd, b.vx_td_mps.sd, weight_sd_mps);
  const double slip_lo_mps = b.vx_lo_mps->value + radius_m * b.omega_lo_radps.value;
  const double spin_sd = radius_m * std::hypot(b.omega_lo_radps.sd, b.omega_td_radps.sd);
  return Balance{.alpha = {alpha, std::hypot(change_sd, alpha * spin_sd) / std::abs(spin_mps)},
                 .offset_m = {friction->offset_m, friction->offset_sd_m},
                 .offset_sd_alpha_m = friction->offset_sd_alpha_m,
                 .slip_lo_mps = slip_lo_mps,
                 .e_x = -slip_lo_mps / (b.vx_td_mps.value + radius_m * b.omega_td_radps.value)};
}

MeanAlpha mean_of(std::span<const published::Measured> alphas) {
  double weights = 0.0, sum = 0.0;
  for (const published::Measured& a : alphas) {
    weights += 1.0 / (a.sd * a.sd);
    sum += a.value / (a.sd * a.sd);
  }
  MeanAlpha mean{.alpha = {sum / weights, 1.0 / std::sqrt(weights)},
                 .count = static_cast<int>(alphas.size())};
  for (const published::Measured& a : alphas)
    mean.chi_square += std::pow((a.value - mean.alpha.value) / a.sd, 2);
  return mean;
}

}  // namespace strobe::bounces
