// explain_stiffness(): hypotheses against published stiffnesses.
#include <cmath>
#include <numbers>
#include <string_view>

#include "common/contact/integration/peaks.hpp"
#include "common/contact/integration/stiffness.hpp"

namespace strobe::contact {

namespace {

using std::numbers::pi;

/// The last ones are forces, over a length that is left open.
constexpr std::size_t kOpenLengths = 3;
constexpr std::string_view kNames[] = {
    "m (pi/dwell)^2",
    "pulse: largest force over largest depth",
    "m vy^2 over largest depth squared",
    "quarter period to the deepest point",
    "quarter period to the largest force",
    "Kelvin-Voigt spring of (e, dwell)",
    "Hertz contact (F ~ depth^1.5), secant",
    "F ~ depth^2.6, secant",
    "pulse's largest force over measured drop",
    "undamped pulse (m |vy| pi/dwell) over one depth",
    "pulse's largest force over one depth",
    "half wave of the measured impulse over one depth",
};

/// Secant stiffness F/depth at the deepest point of F = K·depth^n over m(pi/dwell)², from energy and from the
/// duration 2·(depth/|vy|)·integral of dx/sqrt(1 - x^(n+1)): lossless.
double power_law_factor(double n) {
  const double share = 1.0 / (n + 1.0);
  const double quarter = std::sqrt(pi) * std::tgamma(1.0 + share) / std::tgamma(0.5 + share);
  return 0.5 * (n + 1.0) * std::pow(2.0 * quarter / pi, 2);
}

double half_wave_force_n(const PublishedStiffness& p) {
  return 0.5 * pi * p.input.ball.mass_kg * (p.vy_lo_mps - p.input.touchdown.vy_mps) / p.input.dwell_s;
}

/// What each hypothesis gives for one condition, in the order of kNames, N/m.
tl::expected<std::vector<double>, impact::InputError> predictions(const PublishedStiffness& p) {
  const auto s = stiffness(p.input);
  if (!s) return tl::unexpected(s.error());
  const auto best = peaks(p.input, {});
  if (!best) return tl::unexpected(best.error());
  const double undamped_n = p.input.ball.mass_kg * -p.input.touchdown.vy_mps * pi / p.input.dwell_s;
  return std::vector<double>{s->half_period,
                             s->secant,
                             s->energy,
                             s->compression,
                             s->peak_time,
                             s->kelvin_voigt,
                             power_law_factor(1.5) * s->half_period,
                             power_law_factor(2.6) * s->half_period,
                             best->normal_force.size.value / p.measured_drop_m,
                             undamped_n,
                             best->normal_force.size.value,
                             half_wave_force_n(p)};
}

/// Fills in the ratios; a hypothesis that leaves a length open gets the one that fits best.
void compare(StiffnessHypothesis& h, std::span<const PublishedStiffness> published, bool open_length) {
  double sum = 0.0, squares = 0.0;
  const auto n = static_cast<double>(published.size());
  std::vector<double> logs;
  for (std::size_t i = 0; i < published.size(); ++i) {
    logs.push_back(std::log(published[i].stiffness / h.predicted[i]));
    sum += logs.back();
  }
  const double mean = sum / n;
  for (const double log : logs) squares += (log - mean) * (log - mean);
  h.spread = std::sqrt(squares / (n - 1.0));
  h.common_ratio = std::exp(mean);
  if (open_length) {
    for (double& value : h.predicted) value *= h.common_ratio;
    h.common_ratio = 1.0;
  }
  for (std::size_t i = 0; i < published.size(); ++i)
    h.ratio.push_back(published[i].stiffness / h.predicted[i]);
}

}  // namespace

tl::expected<std::vector<StiffnessHypothesis>, impact::InputError> explain_stiffness(
    std::span<const PublishedStiffness> published) {
  if (published.size() < 2) return tl::unexpected(impact::InputError::not_finite);
  constexpr std::size_t kCount = std::size(kNames);
  std::vector<StiffnessHypothesis> out(kCount);
  for (const PublishedStiffness& p : published) {
    if (!(std::isfinite(p.stiffness) && p.stiffness > 0.0 && p.measured_drop_m > 0.0 &&
          std::isfinite(p.measured_drop_m) && std::isfinite(p.vy_lo_mps)))
      return tl::unexpected(impact::InputError::not_finite);
    const auto predicted = predictions(p);
    if (!predicted) return tl::unexpected(predicted.error());
    for (std::size_t i = 0; i < kCount; ++i) out[i].predicted.push_back((*predicted)[i]);
  }
  for (std::size_t i = 0; i < kCount; ++i) {
    out[i].name = kNames[i];
    compare(out[i], published, i + kOpenLengths >= kCount);
  }
  return out;
}

std::vector<double> fixed_depth_m(std::span<const PublishedStiffness> published) {
  std::vector<double> depths;
  for (const PublishedStiffness& p : published) depths.push_back(half_wave_force_n(p) / p.stiffness);
  return depths;
}

}  // namespace strobe::contact
