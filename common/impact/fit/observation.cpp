#include "common/impact/fit/observation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strobe::impact {

namespace {

/// From a population sd to the sd of the mean, s/sqrt(n) with s² = sd²·n/(n - 1). The sd of a single
/// replicate is kept as printed.
double divisor(Spread spread, int n) {
  return spread == Spread::mean ? std::sqrt(static_cast<double>(std::max(n - 1, 1))) : 1.0;
}

}  // namespace

double z_score(double value, double sd) {
  if (value == 0.0) return 0.0;
  return sd > 0.0 ? value / sd : std::copysign(std::numeric_limits<double>::infinity(), value);
}

std::vector<Observation> observations_of(std::span<const thesis::Condition> conditions, Spread spread) {
  std::vector<Observation> out;
  out.reserve(conditions.size());
  for (const thesis::Condition& c : conditions) {
    const double in = divisor(spread, c.n_incoming);
    const double off = divisor(spread, c.n_rebound);
    out.push_back({.name = c.name(),
                   .spin = c.spin,
                   .series = c.name(),
                   .touchdown = {c.vx_td_mps.mean, c.vy_td_mps.mean, c.omega_td_radps.mean},
                   .touchdown_sd = {c.vx_td_mps.sd / in, c.vy_td_mps.sd / in, c.omega_td_radps.sd / in},
                   .lift_off = {c.vx_lo_mps.mean, c.vy_lo_mps.mean, c.omega_lo_radps.mean},
                   .lift_off_sd = {c.vx_lo_mps.sd / off, c.vy_lo_mps.sd / off, c.omega_lo_radps.sd / off},
                   .e = c.e.mean,
                   .e_sd = c.e.sd / divisor(spread, c.n_system),
                   .dwell_s = c.dwell_time_ms.mean / 1e3,
                   .dwell_sd_s = c.dwell_time_ms.sd / 1e3 / divisor(spread, c.n_system)});
  }
  return out;
}

}  // namespace strobe::impact
