#include "common/impact/closed_form/brody.hpp"

#include <cmath>

namespace strobe::impact {

namespace {

/// Inputs are checked by rigid().
tl::expected<double, InputError> normal_impulse(const ball::Ball& ball, const Motion& touchdown, double e,
                                                double mu) {
  const auto checked = rigid(ball, touchdown, e, mu);
  if (!checked) return tl::unexpected(checked.error());
  return -(1.0 + e) * touchdown.vy_mps;
}

Rebound slid(const ball::Ball& ball, const Motion& touchdown, double e, double mu, double impulse) {
  const double radius = ball.radius_m();
  const double slip = std::fma(radius, touchdown.omega_radps, touchdown.vx_mps);
  const double direction = slip > 0.0 ? 1.0 : slip < 0.0 ? -1.0 : 0.0;
  const double friction = direction * mu * impulse;
  Rebound out;
  out.lift_off = {touchdown.vx_mps - friction, -e * touchdown.vy_mps,
                  touchdown.omega_radps - friction / (ball.alpha * radius)};
  out.regime = Regime::slides;
  out.slip_lo_mps = slip - friction * (1.0 + 1.0 / ball.alpha);
  out.impulse_ratio = direction * mu;
  return out;
}

Rebound rolled(const ball::Ball& ball, const Motion& touchdown, double e, double impulse) {
  const double radius = ball.radius_m();
  const double slip = std::fma(radius, touchdown.omega_radps, touchdown.vx_mps);
  const double vx = (touchdown.vx_mps - ball.alpha * radius * touchdown.omega_radps) / (1.0 + ball.alpha);
  Rebound out;
  out.lift_off = {vx, -e * touchdown.vy_mps, -vx / radius};
  out.regime = Regime::grips;
  out.impulse_ratio = slip * ball.alpha / ((1.0 + ball.alpha) * impulse);
  return out;
}

}  // namespace

tl::expected<Rebound, InputError> slide(const ball::Ball& ball, const Motion& touchdown, double e,
                                        double mu) {
  return normal_impulse(ball, touchdown, e, mu).map([&](double impulse) {
    return slid(ball, touchdown, e, mu, impulse);
  });
}

tl::expected<Rebound, InputError> roll(const ball::Ball& ball, const Motion& touchdown, double e) {
  return normal_impulse(ball, touchdown, e, 0.0).map([&](double impulse) {
    return rolled(ball, touchdown, e, impulse);
  });
}

tl::expected<SlideOrRoll, InputError> slide_or_roll(const ball::Ball& ball, const Motion& touchdown, double e,
                                                    double mu) {
  return normal_impulse(ball, touchdown, e, mu).map([&](double impulse) {
    SlideOrRoll out{.rebound = rolled(ball, touchdown, e, impulse)};
    out.rolling_impulse_ratio = std::abs(out.rebound.impulse_ratio);
    if (mu < out.rolling_impulse_ratio) out.rebound = slid(ball, touchdown, e, mu, impulse);
    return out;
  });
}

}  // namespace strobe::impact
