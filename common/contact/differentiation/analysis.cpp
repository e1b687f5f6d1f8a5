#include "common/contact/differentiation/analysis.hpp"

#include <cmath>
#include <string>

namespace strobe::contact {

namespace {

std::optional<CubicFit> fitted(std::span<const double> t, std::span<const double> y) {
  auto fit = fit_cubic(t, y);
  if (!fit) return std::nullopt;
  return *std::move(fit);
}

Result<impact::SinePulse> pulse_of(const Inputs& in) {
  if (!(std::isfinite(in.dwell_distance_m) && in.dwell_distance_m > 0.0))
    return fail("dwell distance must be positive");
  if (!(std::isfinite(in.diameter_m) && in.diameter_m > 0.0)) return fail("diameter must be positive");
  const auto pulse = impact::SinePulse::make(in.form, {.vx_td_mps = in.vx_td_mps,
                                                       .vy_td_mps = in.vy_td_mps,
                                                       .e = in.e,
                                                       .impulse_ratio = in.mu,
                                                       .dwell_s = in.dwell_time_s});
  if (!pulse) return fail(std::string(impact::message(pulse.error())));
  return *pulse;
}

}  // namespace

Result<Estimate> estimate_error(const ContactSet& set, const Inputs& inputs) {
  const auto pulse = pulse_of(inputs);
  if (!pulse) return tl::unexpected(pulse.error());
  double squares_x = 0.0;
  double squares_y = 0.0;
  int n = 0;
  for (const ContactRow& row : set.rows) {
    if (is_end_point(row)) continue;
    const impact::PulseState state = pulse->at_fraction(row.time_fraction);
    squares_x += std::pow(row.x_fraction * inputs.dwell_distance_m - state.x_m, 2);
    squares_y += std::pow(row.y_fraction * inputs.diameter_m - state.y_m, 2);
    ++n;
  }
  if (n < 2) return fail("at least two rows are needed between touchdown and lift-off");
  return Estimate{std::sqrt(squares_x / (n - 1)), std::sqrt(squares_y / (n - 1)), n, pulse->damping()};
}

FractionFits fit_fractions(const ContactSet& set) {
  std::vector<double> t, x, y, t_rotation, rotation;
  for (const ContactRow& row : set.rows) {
    t.push_back(row.time_fraction);
    x.push_back(row.x_fraction);
    y.push_back(row.y_fraction);
    if (!row.rotation_fraction) continue;
    t_rotation.push_back(row.time_fraction);
    rotation.push_back(*row.rotation_fraction);
  }
  return {fitted(t, x), fitted(t, y), fitted(t_rotation, rotation)};
}

}  // namespace strobe::contact
