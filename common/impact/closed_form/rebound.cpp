#include "common/impact/closed_form/grip_impulse.hpp"

namespace strobe::impact {

namespace {

bool all_finite(const ball::Ball& b, const Motion& m, const Coefficients& c) {
  return std::isfinite(b.diameter_m) && std::isfinite(b.mass_kg) && std::isfinite(b.alpha) &&
         std::isfinite(m.vx_mps) && std::isfinite(m.vy_mps) && std::isfinite(m.omega_radps) &&
         std::isfinite(c.e) && std::isfinite(c.mu) && std::isfinite(c.e_x) && std::isfinite(c.offset_m) &&
         std::isfinite(c.offset_reference_mps);
}

bool magnitudes_in_range(const ball::Ball& b, const Motion& m, const Coefficients& c) {
  return !(too_large(b.diameter_m) || too_large(b.mass_kg) || too_large(m.vx_mps) || too_large(m.vy_mps) ||
           too_large(m.omega_radps) || too_small(-m.vy_mps) || too_large(c.mu) ||
           too_large(c.offset_reference_mps) || too_small(b.diameter_m) || too_small(b.mass_kg) ||
           too_small(b.alpha) || too_small(c.offset_reference_mps));
}

}  // namespace

namespace detail {

std::optional<InputError> find_error(const ball::Ball& b, const Motion& m, const Coefficients& c) {
  if (!all_finite(b, m, c)) return InputError::not_finite;
  if (b.diameter_m <= 0.0 || b.mass_kg <= 0.0 || b.alpha <= 0.0 || b.alpha > ball::kThinShellAlpha)
    return InputError::ball_out_of_range;
  if (m.vy_mps >= 0.0) return InputError::not_approaching;
  if (c.e < 0.0 || c.e > 1.0) return InputError::restitution_out_of_range;
  if (c.mu < 0.0) return InputError::friction_negative;
  if (c.e_x < -1.0 || c.e_x > 1.0) return InputError::tangential_restitution_out_of_range;
  if (c.offset_m < 0.0 || c.offset_m >= b.radius_m() || c.offset_reference_mps <= 0.0)
    return InputError::offset_out_of_range;
  if (!magnitudes_in_range(b, m, c)) return InputError::magnitude_out_of_range;
  return std::nullopt;
}

}  // namespace detail

Regime regime_of(const ball::Ball& ball, const Motion& touchdown, const Rebound& rebound) {
  const double slip = std::fma(ball.radius_m(), touchdown.omega_radps, touchdown.vx_mps);
  return regime_of_exact(slip, touchdown.vx_mps - rebound.lift_off.vx_mps, ball.alpha);
}

tl::expected<Rebound, InputError> grip(const ball::Ball& ball, const Motion& touchdown,
                                       const Coefficients& c) {
  if (const auto error = detail::find_error(ball, touchdown, c)) return tl::unexpected(*error);
  const double radius = ball.radius_m();
  const double vx = touchdown.vx_mps;
  const double spin = radius * touchdown.omega_radps;
  const double slip = std::fma(radius, touchdown.omega_radps, vx);
  const double impulse = -(1.0 + c.e) * touchdown.vy_mps;
  const auto change = detail::grip_impulse(ball, slip, spin, 0.5 * (vx - spin), impulse, c);

  Rebound out;
  out.lift_off = {vx + change.dv, -c.e * touchdown.vy_mps, touchdown.omega_radps + change.dspin / radius};
  out.regime = change.grips ? Regime::grips : Regime::slides;
  out.slip_lo_mps = change.slip_lo;
  out.impulse_ratio = (0.0 - change.dv) / impulse;
  out.offset_m = change.offset;
  return out;
}

tl::expected<Rebound, InputError> rigid(const ball::Ball& ball, const Motion& touchdown, double e,
                                        double mu) {
  return grip(ball, touchdown, Coefficients{.e = e, .mu = mu});
}

}  // namespace strobe::impact
