#include "common/impact/sine_pulse.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

namespace strobe::impact {

namespace {

using std::numbers::pi;

/// Below this theta the integrals are summed as power series: their closed forms cancel like 1/theta² there.
constexpr double kSeriesBelow = 1.0;

/// theta = pi·tau with the sine and cosine taken from the nearer end or middle of 0…1, where the subtraction
/// is exact; so sin is 0 at lift-off and keeps its relative accuracy on the way there.
struct Phase {
  explicit Phase(double tau, double damping) : theta(pi * tau), decay(std::exp(-damping * theta)) {
    sine = tau > 0.5 ? std::sin(pi * (1.0 - tau)) : std::sin(theta);
    cosine = tau > 0.25 ? std::sin(pi * (0.5 - tau)) : std::cos(theta);
  }
  /// 1 - decay·cos(theta), whose terms do not cancel while the cosine is positive.
  double one_minus_decayed_cosine(double damping) const {
    if (cosine <= 0.0) return 1.0 - decay * cosine;
    const double half = std::sin(0.5 * theta);
    return -std::expm1(-damping * theta) + 2.0 * decay * half * half;
  }

  double theta;
  double decay;
  double sine = 0.0;
  double cosine = 0.0;
};

/// Sum over n >= first of Im(z^n)·theta^(n+first_power)/(n+first_power)! with z = -f + i: the integral of
/// exp(-f·phi)·sin(phi), taken once (power 1) or twice (power 2). For theta < 1, |z| < 1.11.
double integral_series(double f, double theta, int power) {
  const std::complex<double> z{-f, 1.0};
  std::complex<double> term = power == 1 ? theta : 0.5 * theta * theta;
  double sum = 0.0;
  for (int n = 1; n < 24; ++n) {
    term *= z * (theta / static_cast<double>(n + power));
    sum += term.imag();
  }
  return sum;
}

/// I1 = integral of exp(-f·phi)·sin(phi) over 0…theta.
double first_integral(double f, const Phase& p) {
  if (std::abs(p.theta) < kSeriesBelow) return integral_series(f, p.theta, 1);
  return (1.0 - p.decay * (f * p.sine + p.cosine)) / (1.0 + f * f);
}

/// theta - I2 >= 0, I2 the integral of I1: every term is positive, so nothing cancels at any theta or f.
double depth_integral(double f, const Phase& p) {
  const double q = 1.0 / (1.0 + f * f);
  const double swing = p.decay * (1.0 - f * f) * p.sine + 2.0 * f * p.one_minus_decayed_cosine(f);
  return q * (p.theta * f * f + q * swing);
}

double second_integral(double f, const Phase& p) {
  return std::abs(p.theta) < kSeriesBelow ? integral_series(f, p.theta, 2) : p.theta - depth_integral(f, p);
}

/// The series of theta - sin(theta), or the difference where it is large.
double theta_minus_sine(const Phase& p) {
  return std::abs(p.theta) < kSeriesBelow ? integral_series(0.0, p.theta, 2) : p.theta - p.sine;
}

/// Root of expm1(-pi·f) + (1 - e) - (1 + e)·f² = 0, which is e = (1 + exp(-pi·f))/(1 + f²) - 1 free of
/// cancellation near e = 1. It falls and is convex over the range of f, so Newton from 0 rises to the root.
double exact_damping(double e) {
  double f = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double value = std::expm1(-pi * f) + (1.0 - e) - (1.0 + e) * f * f;
    const double next = f + value / (pi * std::exp(-pi * f) + 2.0 * (1.0 + e) * f);
    if (std::abs(next - f) <= 1e-16 * next) return next;
    f = next;
  }
  return f;
}

std::optional<InputError> find_error(const PulseInput& in) {
  if (!std::isfinite(in.vx_td_mps) || !std::isfinite(in.vy_td_mps) || !std::isfinite(in.impulse_ratio) ||
      !std::isfinite(in.dwell_s) || !std::isfinite(in.mass_kg))
    return InputError::not_finite;
  if (in.vy_td_mps >= 0.0) return InputError::not_approaching;
  if (in.dwell_s <= 0.0) return InputError::dwell_not_positive;
  if (in.mass_kg <= 0.0) return InputError::ball_out_of_range;
  return std::nullopt;
}

}  // namespace

tl::expected<double, InputError> damping_from_restitution(PulseForm form, double e) {
  if (!std::isfinite(e)) return tl::unexpected(InputError::not_finite);
  if (e < 0.0 || e > 1.0) return tl::unexpected(InputError::restitution_out_of_range);
  if (form == PulseForm::exact) return exact_damping(e);
  if (e == 0.0) return tl::unexpected(InputError::damping_undefined);
  return std::abs(std::log(e)) / pi;
}

tl::expected<SinePulse, InputError> SinePulse::make(PulseForm form, const PulseInput& input) {
  if (const auto error = find_error(input)) return tl::unexpected(*error);
  const auto damping = damping_from_restitution(form, input.e);
  if (!damping) return tl::unexpected(damping.error());
  return SinePulse(form, input, *damping);
}

double SinePulse::max_force_n() const { return -input_.mass_kg * input_.vy_td_mps * pi / input_.dwell_s; }

PulseState SinePulse::at_fraction(double time_fraction) const {
  const Phase p(time_fraction, damping_);
  const double speed = -input_.vy_td_mps;
  const double length = speed * input_.dwell_s / pi;  // |vy|/w
  const bool exact = form_ == PulseForm::exact;
  const double impulse = exact ? first_integral(damping_, p) : p.one_minus_decayed_cosine(damping_);
  const double lag =
      exact ? second_integral(damping_, p) : theta_minus_sine(p) - std::expm1(-damping_ * p.theta) * p.sine;
  const double depth = exact ? depth_integral(damping_, p) : p.decay * p.sine;

  PulseState s;
  s.vx_mps = input_.vx_td_mps - input_.impulse_ratio * speed * impulse;
  s.vy_mps = exact ? speed * (impulse - 1.0) : -speed * p.decay * p.cosine;
  s.x_m = input_.vx_td_mps * (time_fraction * input_.dwell_s) - input_.impulse_ratio * length * lag;
  s.y_m = 0.0 - length * depth;  // not a negative zero
  s.fy_n = max_force_n() * p.decay * p.sine;
  s.fx_n = 0.0 - input_.impulse_ratio * s.fy_n;
  s.impulse_fraction = impulse / (1.0 + input_.e);
  return s;
}

double SinePulse::fraction_at_impulse(double fraction) const {
  // The simplified impulse rises up to tan(theta) = -f, the exact one up to the end.
  double low = 0.0;
  double high = form_ == PulseForm::exact ? 1.0 : 1.0 - std::atan(damping_) / pi;
  if (fraction <= 0.0) return low;
  if (at_fraction(high).impulse_fraction <= fraction) return high;
  // Newton on the impulse, whose slope is the force; bisection wherever a step leaves the bracket.
  const double target = fraction * (1.0 + input_.e);
  double tau = 0.5 * (low + high);
  for (int i = 0; i < 60; ++i) {
    const Phase p(tau, damping_);
    const bool exact = form_ == PulseForm::exact;
    const double miss = (exact ? first_integral(damping_, p) : p.one_minus_decayed_cosine(damping_)) - target;
    const double slope = pi * p.decay * (p.sine + (exact ? 0.0 : damping_ * p.cosine));
    (miss < 0.0 ? low : high) = tau;
    double next = tau - miss / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - tau) < 1e-14) return next;
    tau = next;
  }
  return tau;
}

tl::expected<PulseRebound, InputError> pulse_rebound(PulseForm form, const ball::Ball& ball,
                                                     const Motion& touchdown, double e, double mu,
                                                     double dwell_s) {
  const auto rebound = rigid(ball, touchdown, e, mu);
  if (!rebound) return tl::unexpected(rebound.error());
  const double slip = touchdown.vx_mps + ball.radius_m() * touchdown.omega_radps;
  const auto pulse = SinePulse::make(form, {.vx_td_mps = touchdown.vx_mps,
                                            .vy_td_mps = touchdown.vy_mps,
                                            .e = e,
                                            .impulse_ratio = slip == 0.0 ? 0.0 : std::copysign(mu, slip),
                                            .dwell_s = dwell_s,
                                            .mass_kg = ball.mass_kg});
  if (!pulse) return tl::unexpected(pulse.error());

  PulseRebound out{.rebound = *rebound, .damping_f = pulse->damping()};
  const double peak = std::atan2(1.0, pulse->damping());  // where exp(-f·theta)·sin(theta) is largest
  out.max_force_n = pulse->max_force_n() * std::exp(-pulse->damping() * peak) * std::sin(peak);
  const double lowest = form == PulseForm::exact ? pulse->fraction_at_impulse(1.0 / (1.0 + e)) : peak / pi;
  out.depth_m = -pulse->at_fraction(lowest).y_m;
  if (rebound->regime == Regime::grips)
    out.grip_fraction = slip == 0.0 ? 0.0 : pulse->fraction_at_impulse(std::abs(rebound->impulse_ratio) / mu);
  out.dwell_distance_m = pulse->at_fraction(out.grip_fraction).x_m +
                         rebound->lift_off.vx_mps * (1.0 - out.grip_fraction) * dwell_s;
  return out;
}

}  // namespace strobe::impact
