// The two fundamental solutions of v'' + omega2·v = 0, whichever sign omega2 has: cosine = cos(q·t), sine =
// sin(q·t)/q with q² = omega2, continued to omega2 <= 0 by the hyperbolic functions. Pure, no allocation.
#pragma once

#include <array>
#include <cmath>

namespace strobe::impact::detail {

struct Oscillation {
  double cosine;
  double sine;
};

/// |omega2·t²| up to which oscillation_series() keeps its digits: beyond pi², so that half a turn is inside.
inline constexpr double kMaxSeriesPhase2 = 11.0;

/// 1/(2k)! and 1/(2k + 1)!.
struct SeriesCoefficients {
  std::array<double, 12> even{}, odd{};
  constexpr SeriesCoefficients() {
    double factorial = 1.0;
    for (std::size_t k = 0; k < 12; ++k) {
      const auto twice = static_cast<double>(2 * k);
      if (k > 0) factorial *= (twice - 1.0) * twice;
      even[k] = 1.0 / factorial;
      odd[k] = 1.0 / (factorial * (twice + 1.0));
    }
  }
};
inline constexpr SeriesCoefficients kSeries{};

/// By the series at half the angle, whose terms beyond the eleventh are below 1e-17 of the first.
inline Oscillation oscillation_series(double omega2, double t) {
  constexpr std::size_t terms = 11;
  const double w = -0.25 * omega2 * (t * t);
  double c = kSeries.even[terms], s = kSeries.odd[terms];
  for (std::size_t k = terms; k-- > 0;) {
    c = kSeries.even[k] + c * w;
    s = kSeries.odd[k] + s * w;
  }
  return {1.0 + 2.0 * w * s * s, t * s * c};
}

inline Oscillation oscillation(double omega2, double t) {
  if (std::abs(omega2 * t * t) <= kMaxSeriesPhase2) return oscillation_series(omega2, t);
  const double q = std::sqrt(std::abs(omega2));
  if (omega2 > 0.0) return {std::cos(q * t), std::sin(q * t) / q};
  return {std::cosh(q * t), std::sinh(q * t) / q};
}

}  // namespace strobe::impact::detail
