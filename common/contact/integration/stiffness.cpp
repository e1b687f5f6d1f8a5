// Readings of the contact's stiffness, and the measured drop of the top beside the pulse's depth.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/contact/integration/integration.hpp"
#include "common/contact/integration/pulse_depth.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::contact {

namespace {

using std::numbers::pi;

struct Drop {
  double ratio;
  double sum_squares;
};

Drop fitted_drop(const ContactSet& set, const SpinPulse& pulse) {
  double yy = 0.0, ym = 0.0;
  for (const ContactRow& row : set.rows) {
    if (is_end_point(row)) continue;
    const double y = pulse.at_fraction(row.time_fraction).y_m;
    yy += y * y;
    ym += y * row.y_fraction * pulse.input().ball.diameter_m;
  }
  return {ym / yy, yy};
}

}  // namespace

tl::expected<Stiffness, impact::InputError> stiffness(const SpinPulseInput& input) {
  const auto pulse = SpinPulse::make(input);
  if (!pulse) return tl::unexpected(pulse.error());
  const double mass = input.ball.mass_kg;
  const double peak_fraction = std::atan2(1.0, pulse->damping()) / pi;
  const double deepest = deepest_fraction(*pulse);
  const double depth_m = -pulse->at_fraction(deepest).y_m;
  const auto of_period = [&](double half_period_s) { return mass * std::pow(pi / half_period_s, 2); };
  Stiffness out;
  out.half_period = of_period(input.dwell_s);
  out.secant = pulse->at_fraction(peak_fraction).fy_n / depth_m;
  out.energy = mass * std::pow(input.touchdown.vy_mps / depth_m, 2);
  out.compression = of_period(2.0 * deepest * input.dwell_s);
  out.peak_time = of_period(2.0 * peak_fraction * input.dwell_s);
  if (const auto spring = impact::normal_spring(mass, input.e, input.dwell_s)) {
    out.kelvin_voigt = spring->stiffness_npm;
    out.kelvin_voigt_zeta = spring->damping_ratio;
    out.kelvin_voigt_damping = spring->damping_nspm;
  }
  return out;
}

Result<DropRatio> drop_ratio(const ContactSet& set, const SpinPulseInput& input, const SpinPulseSd& sd) {
  const auto pulse = SpinPulse::make(input);
  if (!pulse) return fail(std::string(impact::message(pulse.error())));
  const auto best = peaks(input, sd);
  if (!best) return fail(std::string(impact::message(best.error())));
  DropRatio out;
  for (const ContactRow& row : set.rows) out.n += is_end_point(row) ? 0 : 1;
  const Drop drop = fitted_drop(set, *pulse);
  if (out.n < 2 || !(drop.sum_squares > 0.0))
    return fail("at least two rows are needed between touchdown and lift-off");
  out.ratio = drop.ratio;
  double squares = 0.0;
  for (const ContactRow& row : set.rows) {
    if (is_end_point(row)) continue;
    const double scaled = out.ratio * pulse->at_fraction(row.time_fraction).y_m;
    squares += std::pow(row.y_fraction * input.ball.diameter_m - scaled, 2);
  }
  out.see_m = std::sqrt(squares / (out.n - 1));
  out.sd_images = out.see_m / std::sqrt(drop.sum_squares);
  const ValueSd depth = best->deformation.size;
  const double diameter_share = sd.diameter_m / input.ball.diameter_m;
  out.sd_inputs = std::abs(out.ratio) * std::hypot(depth.sd / depth.value, diameter_share);
  out.depth_m = out.ratio * depth.value;
  return out;
}

}  // namespace strobe::contact
