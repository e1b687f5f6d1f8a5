#include "common/impact/fit/observation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

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

namespace {

Motion larger(const Motion& a, const Motion& b) {
  return {std::max(a.vx_mps, b.vx_mps), std::max(a.vy_mps, b.vy_mps), std::max(a.omega_radps, b.omega_radps)};
}

void take_larger_sds(const Observation& from, Observation& into) {
  into.touchdown_sd = larger(into.touchdown_sd, from.touchdown_sd);
  into.lift_off_sd = larger(into.lift_off_sd, from.lift_off_sd);
  into.e_sd = std::max(into.e_sd, from.e_sd);
  into.dwell_sd_s = std::max(into.dwell_sd_s, from.dwell_sd_s);
}

struct Kept {
  std::size_t at = 0;
  int count = 0;
};

}  // namespace

std::vector<std::string> leave_copies_out(std::vector<Observation>& observations) {
  std::map<std::array<double, 6>, Kept> kept;  // by what every model fits
  std::vector<Observation> out;
  for (Observation& o : observations) {
    const auto [place, added] =
        kept.try_emplace({o.touchdown.vx_mps, o.touchdown.vy_mps, o.touchdown.omega_radps, o.lift_off.vx_mps,
                          o.lift_off.omega_radps, o.e},
                         Kept{.at = out.size()});
    ++place->second.count;
    added ? out.push_back(std::move(o)) : take_larger_sds(o, out[place->second.at]);
  }
  observations = std::move(out);
  std::vector<std::string> lines(observations.size());
  for (const auto& [numbers, k] : kept)
    if (k.count > 1)
      lines[k.at] = observations[k.at].name + ": " + std::to_string(k.count) +
                    " with the same numbers, which count as one";
  std::erase(lines, "");
  return lines;
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
