#include "common/impact/closed_form/rebound.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

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

/// Friction's impulse per mass, and whether it suffices for the contact point to grip.
struct Friction {
  double dvx_mps;
  bool grips;
};

/// `moment` = d·J/R: the angular impulse of the normal force over R, per mass.
Friction friction_impulse(double alpha, double slip, double e_x, double limit, double moment) {
  const double needed = -((1.0 + e_x) * slip * alpha + moment) / (1.0 + alpha);
  const double dvx = std::clamp(needed, -limit, limit);
  return {dvx, dvx == needed};
}

/// The impact with the normal force under the centre, and the offset's effect on it.
struct OffsetEffect {
  Friction without;
  Friction with;
  double slip_without;  ///< slip at lift-off
  double dvx;           ///< changes of vx and R·omega by the offset
  double dspin;
};

/// Differences are expanded to keep their digits: the slip after a grip is -e_x·slip however small the slip
/// is beside the speeds, and the offset's effect is not the difference of two larger numbers.
OffsetEffect offset_effect(double alpha, double slip, const Coefficients& c, double limit, double moment) {
  OffsetEffect s{friction_impulse(alpha, slip, c.e_x, limit, 0.0),
                 friction_impulse(alpha, slip, c.e_x, limit, moment), 0.0, 0.0, 0.0};
  s.slip_without = s.without.grips ? -c.e_x * slip : slip + s.without.dvx_mps * (1.0 + 1.0 / alpha);
  s.dvx = s.without.grips && s.with.grips ? -moment / (1.0 + alpha) : s.with.dvx_mps - s.without.dvx_mps;
  s.dspin = (s.dvx + moment) / alpha;
  return s;
}

/// Largest fraction, 0…1, of the offset's effect that does not raise the tangential energy above that before
/// the impact. The change of energy is a convex parabola in the fraction x, a·x² + b·x + c: c is the change
/// without offset (never a gain), b·x the work of friction and of the moment. Its root is continuous in the
/// inputs; of its two forms the one is used that adds numbers of like sign.
double max_offset_fraction(double alpha, double slip, double e_x, double spin, double moment,
                           const OffsetEffect& s) {
  const double dvx = s.without.dvx_mps;
  const double a = 0.5 * (s.dvx * s.dvx + alpha * s.dspin * s.dspin);
  const double b = s.dvx * s.slip_without + moment * (spin + dvx / alpha);
  const double c = s.without.grips ? -0.5 * (1.0 - e_x) * (1.0 + e_x) * slip * slip * (alpha / (1.0 + alpha))
                                   : std::min(0.0, 0.5 * dvx * (slip + s.slip_without));
  if (a + b + c <= 0.0 || a == 0.0) return 1.0;
  const double root = std::sqrt(b * b - 4.0 * a * c);
  return std::clamp(b > 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a), 0.0, 1.0);
}

}  // namespace

Regime regime_of(const ball::Ball& ball, const Motion& touchdown, const Rebound& rebound) {
  const double slip = std::fma(ball.radius_m(), touchdown.omega_radps, touchdown.vx_mps);
  return regime_of_exact(slip, touchdown.vx_mps - rebound.lift_off.vx_mps, ball.alpha);
}

tl::expected<Rebound, InputError> grip(const ball::Ball& ball, const Motion& touchdown,
                                       const Coefficients& c) {
  if (const auto error = find_error(ball, touchdown, c)) return tl::unexpected(*error);
  const double radius = ball.radius_m();
  const double vx = touchdown.vx_mps;
  const double spin = radius * touchdown.omega_radps;
  const double slip = std::fma(radius, touchdown.omega_radps, vx);
  const double impulse = -(1.0 + c.e) * touchdown.vy_mps;
  const double rolling = 0.5 * (vx - spin);
  const double offset = c.offset_m * rolling / std::hypot(rolling, c.offset_reference_mps);
  const double moment = offset * impulse / radius;

  const OffsetEffect effect = offset_effect(ball.alpha, slip, c, c.mu * impulse, moment);
  const double fraction =
      moment == 0.0 ? 1.0 : max_offset_fraction(ball.alpha, slip, c.e_x, spin, moment, effect);
  const double dvx = fraction < 1.0 ? effect.without.dvx_mps + fraction * effect.dvx : effect.with.dvx_mps;
  const double dspin = (dvx + fraction * moment) / ball.alpha;
  const bool grips = (fraction < 1.0 ? effect.without : effect.with).grips;

  Rebound out;
  out.lift_off = {vx + dvx, -c.e * touchdown.vy_mps, touchdown.omega_radps + dspin / radius};
  out.regime = grips ? Regime::grips : Regime::slides;
  out.slip_lo_mps = fraction == 1.0 && grips ? -c.e_x * slip : slip + dvx + dspin;
  out.impulse_ratio = (0.0 - dvx) / impulse;
  out.offset_m = fraction * offset;
  return out;
}

tl::expected<Rebound, InputError> rigid(const ball::Ball& ball, const Motion& touchdown, double e,
                                        double mu) {
  return grip(ball, touchdown, Coefficients{.e = e, .mu = mu});
}

}  // namespace strobe::impact
