#include "common/impact/closed_form/pulse_integrals.hpp"

#include <array>
#include <cmath>
#include <numbers>

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

tl::expected<PulseIntegrals, InputError> pulse_integrals(double damping_f, double theta_rad) {
  if (!std::isfinite(damping_f) || !std::isfinite(theta_rad)) return tl::unexpected(InputError::not_finite);
  if (damping_f < 0.0 || damping_f > kLargestDamping || theta_rad < 0.0 || theta_rad > pi)
    return tl::unexpected(InputError::phase_out_of_range);
  const PulsePhase phase = PulsePhase::at_angle(damping_f, theta_rad);
  return PulseIntegrals{impulse_integral(damping_f, phase), displacement_integral(damping_f, phase),
                        depth_integral(damping_f, phase)};
}

}  // namespace strobe::impact
