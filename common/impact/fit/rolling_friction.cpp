#include "common/impact/fit/rolling_friction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace strobe::impact {

namespace {

bool valid_sd(double sd) { return sd >= 0.0 && sd <= kMaxMagnitude; }

bool valid_sd(const Motion& sd) {
  return valid_sd(sd.vx_mps) && valid_sd(sd.vy_mps) && valid_sd(sd.omega_radps);
}

/// The inputs that the models check, and those that only this function has.
std::optional<InputError> find_error(const Observation& o, const ball::Ball& ball, double alpha_sd) {
  const auto checked = rigid(ball, o.touchdown, o.e, 0.0);
  if (!checked) return checked.error();
  const bool finite = std::isfinite(o.lift_off.vx_mps) && std::isfinite(o.lift_off.omega_radps);
  const bool spreads = valid_sd(o.touchdown_sd) && valid_sd(o.lift_off_sd) && valid_sd(o.e_sd);
  if (!finite || !spreads || !valid_sd(alpha_sd)) return InputError::not_finite;
  const double largest = std::max(std::abs(o.lift_off.vx_mps), std::abs(o.lift_off.omega_radps));
  if (largest > kMaxMagnitude) return InputError::magnitude_out_of_range;
  return std::nullopt;
}

double root_of_squares(std::span<const double> values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum);
}

double weight_of(const RollingFriction& r, bool alike) {
  return alike ? 1.0 : 1.0 / (r.offset_sd_m * r.offset_sd_m);
}

double scatter_about(std::span<const RollingFriction> conditions, double mean_m) {
  if (conditions.size() < 2) return 0.0;
  double squares = 0.0;
  for (const RollingFriction& r : conditions) squares += (r.offset_m - mean_m) * (r.offset_m - mean_m);
  return std::sqrt(squares / static_cast<double>(conditions.size() - 1));
}

}  // namespace

tl::expected<RollingFriction, InputError> rolling_friction(const Observation& o, const ball::Ball& ball,
                                                           double alpha_sd) {
  if (const auto error = find_error(o, ball, alpha_sd)) return tl::unexpected(*error);
  const double radius = ball.radius_m();
  const double impulse = -(1.0 + o.e) * o.touchdown.vy_mps;
  const double turned = radius * (o.lift_off.omega_radps - o.touchdown.omega_radps);
  const double lost = o.touchdown.vx_mps - o.lift_off.vx_mps;

  RollingFriction out{.name = o.name, .spin = o.spin};
  out.coefficient = (ball.alpha * turned + lost) / impulse;
  const double by_spin = ball.alpha * radius / impulse;
  const std::array shares{o.touchdown_sd.vx_mps / impulse,
                          o.lift_off_sd.vx_mps / impulse,
                          by_spin * o.touchdown_sd.omega_radps,
                          by_spin * o.lift_off_sd.omega_radps,
                          out.coefficient * o.touchdown_sd.vy_mps / o.touchdown.vy_mps,
                          out.coefficient * o.e_sd / (1.0 + o.e)};
  out.coefficient_sd = root_of_squares(shares);
  out.coefficient_sd_alpha = alpha_sd * std::abs(turned) / impulse;
  out.offset_m = radius * out.coefficient;
  out.offset_sd_m = radius * out.coefficient_sd;
  out.offset_sd_alpha_m = radius * out.coefficient_sd_alpha;
  out.offset_by_alpha_m = radius * turned / impulse;
  out.rolling_speed_mps = 0.25 * (o.touchdown.vx_mps + o.lift_off.vx_mps -
                                  radius * (o.touchdown.omega_radps + o.lift_off.omega_radps));
  out.z_from_symmetry = z_score(out.offset_m, out.offset_sd_m);
  return out;
}

RollingFrictionSummary summarize(std::span<const RollingFriction> conditions) {
  RollingFrictionSummary out;
  if (conditions.empty()) return out;
  const auto n = static_cast<double>(conditions.size());
  out.count = static_cast<int>(conditions.size());
  const bool alike =
      std::any_of(conditions.begin(), conditions.end(), [](const auto& r) { return r.offset_sd_m == 0.0; });
  double weights = 0.0;
  double sd_alpha = 0.0;
  for (const RollingFriction& r : conditions) {
    out.positive += r.offset_m > 0.0 ? 1 : 0;
    out.mean_m += r.offset_m / n;
    sd_alpha += std::copysign(r.offset_sd_alpha_m, r.offset_by_alpha_m) / n;
    weights += weight_of(r, alike);
    out.weighted_mean_m += weight_of(r, alike) * r.offset_m;
  }
  out.weighted_mean_m /= weights;
  out.scatter_m = scatter_about(conditions, out.mean_m);
  out.weighted_mean_sd_m = alike ? out.scatter_m / std::sqrt(n) : 1.0 / std::sqrt(weights);
  out.mean_sd_alpha_m = std::abs(sd_alpha);
  for (const RollingFriction& r : conditions) {
    if (alike) break;
    out.chi2_of_one_value += std::pow((r.offset_m - out.weighted_mean_m) / r.offset_sd_m, 2);
  }
  return out;
}

}  // namespace strobe::impact
