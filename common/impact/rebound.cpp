#include "common/impact/rebound.hpp"

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

std::optional<InputError> find_error(const ball::Ball& b, const Motion& m, const Coefficients& c) {
  if (!all_finite(b, m, c)) return InputError::not_finite;
  if (b.diameter_m <= 0.0 || b.mass_kg <= 0.0 || b.alpha <= 0.0 || b.alpha > ball::kThinShellAlpha)
    return InputError::ball_out_of_range;
  if (m.vy_mps >= 0.0) return InputError::not_approaching;
  if (c.e < 0.0 || c.e > 1.0) return InputError::restitution_out_of_range;
  if (c.mu < 0.0) return InputError::friction_negative;
  if (c.e_x < -1.0 || c.e_x > 1.0) return InputError::tangential_out_of_range;
  if (c.offset_m < 0.0 || c.offset_m >= b.radius_m() || c.offset_reference_mps <= 0.0)
    return InputError::offset_out_of_range;
  return std::nullopt;
}

/// Changes of the tangential motion, in m/s: of vx, and of R·omega.
struct Change {
  double vx;
  double spin;
  bool gripped;
};

/// `push` = d·J/R, the moment of the normal force.
Change tangential_change(double alpha, double slip, double e_x, double friction_limit, double push) {
  const double needed = -((1.0 + e_x) * slip * alpha + push) / (1.0 + alpha);
  const double dvx = std::clamp(needed, -friction_limit, friction_limit);
  return {dvx, (dvx + push) / alpha, dvx == needed};
}

/// Largest share, 0…1, of the step from `without` to `with` that leaves the tangential energy at or below
/// what it was before the impact. The energy is a convex parabola in the share and `without` never adds any,
/// so there is one root, continuous in the inputs.
double share_without_energy_gain(double alpha, double vx, double spin, const Change& without,
                                 const Change& with) {
  const double step_vx = with.vx - without.vx;
  const double step_spin = with.spin - without.spin;
  const double a = 0.5 * (step_vx * step_vx + alpha * step_spin * step_spin);
  const double b = (vx + without.vx) * step_vx + alpha * (spin + without.spin) * step_spin;
  const double c = std::min(
      0.0, without.vx * (vx + 0.5 * without.vx) + alpha * without.spin * (spin + 0.5 * without.spin));
  if (a + b + c <= 0.0 || a == 0.0) return 1.0;
  const double root = std::sqrt(b * b - 4.0 * a * c);
  const double share = b > 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a);
  return std::clamp(share, 0.0, 1.0);
}

}  // namespace

tl::expected<Rebound, InputError> grip(const ball::Ball& ball, const Motion& touchdown,
                                       const Coefficients& c) {
  if (const auto error = find_error(ball, touchdown, c)) return tl::unexpected(*error);
  const double radius = ball.radius_m();
  const double vx = touchdown.vx_mps;
  const double spin = radius * touchdown.omega_radps;
  const double slip = vx + spin;
  const double impulse = -(1.0 + c.e) * touchdown.vy_mps;
  const double rolling = 0.5 * (vx - spin);
  const double offset = c.offset_m * rolling / std::hypot(rolling, c.offset_reference_mps);

  const Change without = tangential_change(ball.alpha, slip, c.e_x, c.mu * impulse, 0.0);
  const Change with = tangential_change(ball.alpha, slip, c.e_x, c.mu * impulse, offset * impulse / radius);
  const double share = share_without_energy_gain(ball.alpha, vx, spin, without, with);
  const double dvx = without.vx + share * (with.vx - without.vx);
  const double dspin = without.spin + share * (with.spin - without.spin);

  Rebound out;
  out.lift_off = {vx + dvx, -c.e * touchdown.vy_mps, (spin + dspin) / radius};
  out.regime = (share < 1.0 ? without : with).gripped ? Regime::grips : Regime::slides;
  out.slip_lo_mps = slip + dvx + dspin;
  out.impulse_ratio = (0.0 - dvx) / impulse;
  out.offset_m = share * offset;
  return out;
}

tl::expected<Rebound, InputError> rigid(const ball::Ball& ball, const Motion& touchdown, double e,
                                        double mu) {
  return grip(ball, touchdown, Coefficients{.e = e, .mu = mu});
}

}  // namespace strobe::impact
