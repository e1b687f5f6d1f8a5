#include "common/impact/closed_form/sine_pulse.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace strobe::impact {

namespace {

using std::numbers::pi;

/// Below this angle, and below this f·theta, the differences below are summed as power series.
constexpr double kSeriesBelow = 1.0;

/// c[0] + x·(c[1] + x·(…)).
template <std::size_t N>
double horner(const std::array<double, N>& c, double x) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

constexpr double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

/// 1/2!, 1/3!, …: (exp(x) - 1 - x)/x².
constexpr auto kExponentialTail = [] {
  std::array<double, 17> c{};
  for (int i = 0; i < 17; ++i) c[static_cast<std::size_t>(i)] = 1.0 / factorial(i + 2);
  return c;
}();

/// 1/3!, 2/4!, …: (exp(x)(x - 2) + x + 2)/x³.
constexpr auto kSecondTail = [] {
  std::array<double, 17> c{};
  for (int i = 0; i < 17; ++i) c[static_cast<std::size_t>(i)] = (i + 1) / factorial(i + 3);
  return c;
}();

/// 1/3!, -1/5!, …: (theta - sin(theta))/theta³ in theta².
constexpr auto kSineTail = [] {
  std::array<double, 9> c{};
  for (int i = 0; i < 9; ++i)
    c[static_cast<std::size_t>(i)] = (i % 2 == 0 ? 1.0 : -1.0) / factorial(2 * i + 3);
  return c;
}();

/// 2/4!, -2/6!, …: (theta² - 4·sin²(theta/2))/theta⁴ in theta².
constexpr auto kCosineTail = [] {
  std::array<double, 9> c{};
  for (int i = 0; i < 9; ++i)
    c[static_cast<std::size_t>(i)] = (i % 2 == 0 ? 2.0 : -2.0) / factorial(2 * i + 4);
  return c;
}();

bool is_small(double x) { return std::abs(x) < kSeriesBelow; }

/// 1 - exp(-x)(1 + x), x = f·theta: of the order x²/2.
double exp_remainder_2(double x, double decay) {
  return is_small(x) ? decay * x * x * horner(kExponentialTail, x) : 1.0 - decay * (1.0 + x);
}

/// x(1 + exp(-x)) - 2(1 - exp(-x)): of the order x³/6.
double exp_remainder_3(double x, double decay) {
  return is_small(x) ? decay * x * x * x * horner(kSecondTail, x) : x * (1.0 + decay) - 2.0 * (1.0 - decay);
}

double theta_minus_sine(const PulsePhase& p) {
  const double square = p.theta_rad * p.theta_rad;
  return is_small(p.theta_rad) ? p.theta_rad * square * horner(kSineTail, square) : p.theta_rad - p.sine;
}

}  // namespace

PulsePhase PulsePhase::at_angle(double damping_f, double theta_rad) {
  return {theta_rad, std::exp(-damping_f * theta_rad), std::sin(theta_rad), std::cos(theta_rad),
          std::sin(0.5 * theta_rad)};
}

PulsePhase PulsePhase::at_fraction(double damping_f, double time_fraction) {
  // The sine and cosine are taken from the nearer end or middle of 0…1, where the subtraction is exact.
  const double tau = time_fraction;
  const double theta = pi * tau;
  return {theta, std::exp(-damping_f * theta), tau > 0.5 ? std::sin(pi * (1.0 - tau)) : std::sin(theta),
          tau > 0.25 ? std::sin(pi * (0.5 - tau)) : std::cos(theta), std::sin(0.5 * theta)};
}

double impulse_integral(double f, const PulsePhase& p) {
  const double q = 1.0 / (1.0 + f * f);
  if (!is_small(p.theta_rad)) return q * (1.0 - p.decay * (f * p.sine + p.cosine));
  const double rise = 2.0 * p.half_sine * p.half_sine;  // 1 - cos(theta)
  return q * (exp_remainder_2(f * p.theta_rad, p.decay) + p.decay * (f * theta_minus_sine(p) + rise));
}

double displacement_integral(double f, const PulsePhase& p) {
  const double q = 1.0 / (1.0 + f * f);
  if (!is_small(p.theta_rad)) {
    const double swing = p.decay * (1.0 - f * f) * p.sine + 2.0 * f * simplified_impulse(f, p);
    return q * (p.theta_rad - q * swing);
  }
  const double x = f * p.theta_rad;
  const double square = p.theta_rad * p.theta_rad;
  const double bend = square * square * horner(kCosineTail, square);
  return q * q *
         (f * exp_remainder_3(x, p.decay) + p.theta_rad * exp_remainder_2(x, p.decay) +
          p.decay * ((1.0 - f * f) * theta_minus_sine(p) + f * bend));
}

double depth_integral(double f, const PulsePhase& p) {
  const double q = 1.0 / (1.0 + f * f);
  const double swing = p.decay * (1.0 - f * f) * p.sine + 2.0 * f * simplified_impulse(f, p);
  return q * (p.theta_rad * f * f + q * swing);
}

double simplified_impulse(double f, const PulsePhase& p) {
  // The terms do not cancel where the cosine is negative.
  if (p.cosine <= 0.0) return 1.0 - p.decay * p.cosine;
  return -std::expm1(-f * p.theta_rad) + 2.0 * p.decay * p.half_sine * p.half_sine;
}

double simplified_displacement(double f, const PulsePhase& p) {
  return theta_minus_sine(p) - std::expm1(-f * p.theta_rad) * p.sine;
}

namespace {

using std::numbers::pi;

/// f/(1 - e) of the exact pulse within 1.4e-5, as a polynomial in 1 - e.
constexpr std::array<double, 6> kDampingStart{0.3183063,  0.09490573,  0.03262894,
                                              0.02596873, -0.01288575, 0.01561028};

/// Root of expm1(-pi·f) + (1 - e) - (1 + e)·f² = 0, which is e = (1 + exp(-pi·f))/(1 + f²) - 1 free of
/// cancellation near e = 1. Newton doubles the start's digits each time.
double exact_damping(double e) {
  const double loss = 1.0 - e;
  double ratio = kDampingStart.back();
  for (std::size_t i = kDampingStart.size() - 1; i-- > 0;) ratio = ratio * loss + kDampingStart[i];
  double f = loss * ratio;
  for (int i = 0; i < 2; ++i) {
    const double fallen = std::expm1(-pi * f);
    f += (fallen + loss - (1.0 + e) * f * f) / (pi * (1.0 + fallen) + 2.0 * (1.0 + e) * f);
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
  if (too_large(in.vx_td_mps) || too_large(in.vy_td_mps) || too_large(in.impulse_ratio) ||
      too_large(in.dwell_s) || too_large(in.mass_kg) || too_small(-in.vy_td_mps) || too_small(in.dwell_s) ||
      too_small(in.mass_kg))
    return InputError::magnitude_out_of_range;
  return std::nullopt;
}

/// Normal impulse over m·|vy_TD|, with its first two derivatives by theta.
struct Impulse {
  double value;
  double first;
  double second;
};

Impulse impulse_at(PulseForm form, double f, const PulsePhase& p) {
  if (form == PulseForm::exact)
    return {impulse_integral(f, p), p.decay * p.sine, p.decay * (p.cosine - f * p.sine)};
  return {simplified_impulse(f, p), p.decay * (p.sine + f * p.cosine),
          p.decay * ((1.0 - f * f) * p.cosine - 2.0 * f * p.sine)};
}

/// Angle at which the undamped pulse has given this share, corrected for the damping to first order in f.
double initial_exact(double f, double share) {
  const double angle = 2.0 * std::asin(std::sqrt(share));
  if (share < 1e-6) return angle * (1.0 - 0.25 * pi * f);
  if (share > 1.0 - 1e-6) return angle - 0.25 * pi * f * (pi - angle);
  const double sine = 2.0 * std::sqrt(share * (1.0 - share));
  return angle + f * (1.0 - (angle * (1.0 - 2.0 * share) + pi * share) / sine);
}

double initial_simplified(double f, double target) {
  const double angle =
      target < 0.5 ? 2.0 * std::asin(std::sqrt(0.5 * target)) : std::acos(std::max(1.0 - target, -1.0));
  return std::acos(std::clamp((1.0 - target) * std::exp(f * angle), -1.0, 1.0));
}

/// Time fraction in 0…high at which the impulse first reaches `target`, which is below its largest value:
/// Halley's method, and bisection wherever a step leaves the bracket.
double fraction_reaching(PulseForm form, double f, double target, double start, double high) {
  double low = 0.0;
  double tau = start;
  for (int i = 0; i < 100; ++i) {
    if (!(tau > low && tau < high)) tau = 0.5 * (low + high);
    const Impulse impulse = impulse_at(form, f, PulsePhase::at_fraction(f, tau));
    const double excess = impulse.value - target;
    if (excess == 0.0) return tau;
    const double room = std::min(tau, high - tau);
    (excess < 0.0 ? low : high) = tau;
    double step = 0.5 * (low + high) - tau;
    if (impulse.first > 0.0) {
      const double newton = excess / impulse.first;
      const double halley = 1.0 - 0.5 * newton * (impulse.second / impulse.first);
      step = -newton / (halley > 0.5 ? halley : 1.0) / pi;
    }
    const double next = tau + step;
    // The error that is left is of the step's third order.
    if (std::abs(step) <= 1e-6 * room || next == tau) return std::clamp(next, low, high);
    tau = next;
  }
  return tau;
}

/// The simplified impulse rises only up to tan(theta) = -f.
double end_of_rise(PulseForm form, double f) {
  return form == PulseForm::exact ? 1.0 : 1.0 - std::atan(f) / pi;
}

/// As SinePulse::fraction_at_impulse, for an impulse over m·|vy_TD|.
double fraction_at(PulseForm form, double f, double e, double target) {
  if (!(target > 0.0)) return 0.0;
  const double high = end_of_rise(form, f);
  if (impulse_at(form, f, PulsePhase::at_fraction(f, high)).value <= target) return high;
  const double start = form == PulseForm::exact ? initial_exact(f, std::min(target / (1.0 + e), 1.0))
                                                : initial_simplified(f, target);
  return fraction_reaching(form, f, target, start / pi, high);
}

double displacement_at(PulseForm form, double f, const PulsePhase& p) {
  return form == PulseForm::exact ? displacement_integral(f, p) : simplified_displacement(f, p);
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
  const double tau = std::clamp(time_fraction, kMinTimeFraction, kMaxTimeFraction);
  const PulsePhase p = PulsePhase::at_fraction(damping_, tau);
  const double speed = -input_.vy_td_mps;
  const double length = speed * input_.dwell_s / pi;  // |vy|/w
  const bool exact = form_ == PulseForm::exact;
  const double impulse = exact ? impulse_integral(damping_, p) : simplified_impulse(damping_, p);
  const double depth = exact ? depth_integral(damping_, p) : p.decay * p.sine;

  PulseState s;
  s.vx_mps = input_.vx_td_mps - input_.impulse_ratio * speed * impulse;
  s.vy_mps = exact ? speed * (impulse - 1.0) : -speed * p.decay * p.cosine;
  s.x_m = input_.vx_td_mps * (tau * input_.dwell_s) -
          input_.impulse_ratio * length * displacement_at(form_, damping_, p);
  s.y_m = 0.0 - length * depth;  // not a negative zero
  s.fy_n = max_force_n() * p.decay * p.sine;
  s.fx_n = 0.0 - input_.impulse_ratio * s.fy_n;
  s.impulse_fraction = impulse / (1.0 + input_.e);
  return s;
}

double SinePulse::fraction_at_impulse(double fraction) const {
  return fraction_at(form_, damping_, input_.e, fraction * (1.0 + input_.e));
}

tl::expected<PulseRebound, InputError> pulse_rebound(PulseForm form, const ball::Ball& ball,
                                                     const Motion& touchdown, double e, double mu,
                                                     double dwell_s) {
  const auto rebound = rigid(ball, touchdown, e, mu);
  if (!rebound) return tl::unexpected(rebound.error());
  const double slip = std::fma(ball.radius_m(), touchdown.omega_radps, touchdown.vx_mps);
  const auto pulse = SinePulse::make(form, {.vx_td_mps = touchdown.vx_mps,
                                            .vy_td_mps = touchdown.vy_mps,
                                            .e = e,
                                            .impulse_ratio = slip == 0.0 ? 0.0 : std::copysign(mu, slip),
                                            .dwell_s = dwell_s,
                                            .mass_kg = ball.mass_kg});
  if (!pulse) return tl::unexpected(pulse.error());

  const double f = pulse->damping();
  PulseRebound out{.rebound = *rebound, .damping_f = f};
  // exp(-f·theta)·sin(theta) is largest where tan(theta) = 1/f.
  const double peak = std::atan2(1.0, f);
  out.max_force_n = pulse->max_force_n() * std::exp(-f * peak) / std::sqrt(1.0 + f * f);
  const double length = -touchdown.vy_mps * dwell_s / pi;
  if (form == PulseForm::exact) {
    const double lowest = fraction_at(form, f, e, 1.0);  // where vy = 0
    out.depth_m = length * depth_integral(f, PulsePhase::at_fraction(f, lowest));
  } else {
    out.depth_m = length * std::exp(-f * peak) / std::sqrt(1.0 + f * f);
  }
  if (rebound->regime == Regime::grips) {
    // Without friction the ball grips only where there is no slip.
    const double share = slip == 0.0 || mu == 0.0 ? 0.0 : std::abs(rebound->impulse_ratio) / mu;
    out.grip_fraction = fraction_at(form, f, e, share * (1.0 + e));
  }
  const double lost = displacement_at(form, f, PulsePhase::at_fraction(f, out.grip_fraction));
  out.dwell_distance_m = touchdown.vx_mps * (out.grip_fraction * dwell_s) -
                         pulse->input().impulse_ratio * length * lost +
                         rebound->lift_off.vx_mps * ((1.0 - out.grip_fraction) * dwell_s);
  return out;
}

}  // namespace strobe::impact
