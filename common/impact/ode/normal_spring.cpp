#include "common/impact/ode/normal_spring.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace strobe::impact {

namespace {

/// acos(zeta)/sqrt(1 - zeta²), continued over zeta = 1.
double arc_over_chord(double zeta) {
  const double below = (1.0 - zeta) * (1.0 + zeta);
  if (std::abs(below) < 1e-3) {
    // Series in x = 1 - zeta² of asin(sqrt x)/sqrt x, either sign of x.
    const double x = below;
    return 1.0 + x * (1.0 / 6.0 +
                      x * (3.0 / 40.0 + x * (15.0 / 336.0 + x * (105.0 / 3456.0 + x * (945.0 / 42240.0)))));
  }
  return below > 0.0 ? std::acos(zeta) / std::sqrt(below) : std::acosh(zeta) / std::sqrt(-below);
}

/// zeta with (pi/2 - delta)·tan(delta) = half_log < 1/2, zeta = sin(delta): keeps the digits of light
/// damping.
double light_damping(double half_log) {
  // To 1e-7 of delta; each step of Newton's method squares that.
  constexpr std::array<double, 8> fit{0.636619828269,  0.258011938896, 0.123037469069,  0.0746285756596,
                                      0.0308674535608, 0.115282137569, -0.138034361802, 0.176833992367};
  double delta = 0.0;
  for (std::size_t k = fit.size(); k-- > 0;) delta = fit[k] + delta * half_log;
  delta *= half_log;
  for (int i = 0; i < 20; ++i) {
    const double tangent = std::tan(delta), rest = std::numbers::pi / 2.0 - delta;
    const double step = (rest * tangent - half_log) / (rest * (1.0 + tangent * tangent) - tangent);
    delta -= step;
    if (std::abs(step) <= 1e-9 * delta) break;
  }
  return std::sin(delta);
}

/// sqrt(z)·cot(sqrt(z)) and its derivative, continued to z < 0 by the hyperbolic functions.
struct Cotangent {
  double value;
  double derivative;
};

Cotangent arc_cotangent(double z) {
  if (std::abs(z) < 1e-2) {
    // x·cot(x) in z = x².
    const double value =
        1.0 -
        z * (1.0 / 3.0 +
             z * (1.0 / 45.0 +
                  z * (2.0 / 945.0 + z * (1.0 / 4725.0 + z * (2.0 / 93555.0 + z * (1382.0 / 638512875.0))))));
    const double derivative =
        -(1.0 / 3.0 + z * (2.0 / 45.0 + z * (6.0 / 945.0 + z * (4.0 / 4725.0 + z * (10.0 / 93555.0)))));
    return {value, derivative};
  }
  if (z > 0.0) {
    const double x = std::sqrt(z);
    const double cot = 1.0 / std::tan(x);
    return {x * cot, 0.5 * (cot / x - 1.0 - cot * cot)};
  }
  const double x = std::sqrt(-z);
  const double coth = 1.0 / std::tanh(x);
  return {x * coth, -0.5 * (coth / x + 1.0 - coth * coth)};
}

double heavy_damping(double half_log) {
  double z = 3.0 * (1.0 - half_log);
  for (int i = 0; i < 50; ++i) {
    const Cotangent at = arc_cotangent(z);
    const double step = (at.value - half_log) / at.derivative;
    z -= step;
    if (std::abs(step) <= 4e-16 * (1.0 + std::abs(z))) break;
  }
  return z > 0.0 ? std::cos(std::sqrt(z)) : std::cosh(std::sqrt(-z));
}

}  // namespace

double release_phase(double zeta) { return 2.0 * arc_over_chord(zeta); }

double restitution_of_damping_ratio(double zeta) { return std::exp(-zeta * release_phase(zeta)); }

tl::expected<double, InputError> damping_ratio_from_restitution(double e) {
  if (!std::isfinite(e)) return tl::unexpected(InputError::not_finite);
  if (e < 0.0 || e > 1.0) return tl::unexpected(InputError::restitution_out_of_range);
  if (e < kMinSpringRestitution) return tl::unexpected(InputError::spring_out_of_range);
  const double half_log = -0.5 * std::log(e);
  if (half_log == 0.0) return 0.0;
  return half_log < 0.5 ? light_damping(half_log) : heavy_damping(half_log);
}

tl::expected<NormalSpring, InputError> normal_spring(double mass_kg, double e, double dwell_s) {
  if (!std::isfinite(mass_kg) || !std::isfinite(dwell_s)) return tl::unexpected(InputError::not_finite);
  if (mass_kg <= 0.0) return tl::unexpected(InputError::ball_out_of_range);
  if (dwell_s <= 0.0) return tl::unexpected(InputError::dwell_not_positive);
  if (mass_kg < 1e-30 || mass_kg > 1e30 || dwell_s < 1e-30 || dwell_s > 1e30)
    return tl::unexpected(InputError::magnitude_out_of_range);
  return damping_ratio_from_restitution(e).map([&](double zeta) {
    const double phase = release_phase(zeta), frequency = phase / dwell_s;
    return NormalSpring{.stiffness_npm = mass_kg * frequency * frequency,
                        .damping_nspm = 2.0 * zeta * mass_kg * frequency,
                        .damping_ratio = zeta,
                        .frequency_radps = frequency,
                        .release_phase = phase};
  });
}

}  // namespace strobe::impact
