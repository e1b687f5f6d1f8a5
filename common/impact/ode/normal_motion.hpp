// The two fundamental solutions of v'' + omega2·v = 0, whichever sign omega2 has: cosine = cos(q·t), sine =
// sin(q·t)/q with q² = omega2, continued to omega2 <= 0 by the hyperbolic functions. Pure, no allocation.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "common/impact/ode/contact_system.hpp"

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

// The motion normal to the surface in closed form, gravity included, in contact_system.hpp's units:
//   y = g + exp(-zeta·tau)·(-g·C + (1 - g·zeta)·S),   dy/dtau = exp(-zeta·tau)·(C + (g - zeta)·S),
// C and S the solutions of v'' + (1 - zeta²)·v = 0. Along x, with tau = T·x²(3 - 2x) and T where y next is 0,
// the footprint's radius (a root of y) is smooth at touchdown and at release. With heavy damping, where the
// ball leaves long before y is 0, tau = x²·tau_release. Pure, no allocation: thread-safe, real-time safe.

struct NormalState {
  double tau = 0.0;
  double depth = 0.0;
  double rate = 1.0;
};

class NormalMotion {
 public:
  /// Returns nullopt where the weight is too large a part of the force for the release to be near that
  /// without it.
  static std::optional<NormalMotion> make(const System& system);

  double release_tau() const { return release_; }
  double end() const { return end_; }  ///< x at release
  double tau(double x) const { return x * x * (square_ - cube_ * x); }
  double pace(double x) const { return x * (2.0 * square_ - 3.0 * cube_ * x); }
  double x_of(double tau) const;

  NormalState at(double tau) const {
    const Oscillation o = oscillation(omega2_, tau);
    const double fade = std::exp(-zeta_ * tau);
    return {tau, depth(fade, o.cosine, o.sine), rate(fade, o.cosine, o.sine)};
  }

  double force(const NormalState& n) const { return n.depth + 2.0 * zeta_ * n.rate; }
  double force_rate(const NormalState& n) const { return n.rate + 2.0 * zeta_ * (gravity_ - force(n)); }
  /// Integral of the force since touchdown, and the integral of that.
  double impulse(const NormalState& n) const { return gravity_ * n.tau + (1.0 - n.rate); }
  double impulse_integral(const NormalState& n) const {
    return n.tau + (0.5 * gravity_ * n.tau * n.tau - n.depth);
  }

  /// Where the depth passes `depth`, by Newton's method from `tau`, on whose side of it the deepest point is
  /// not: the depth bends down throughout a contact.
  double passes(double depth, double tau) const;

  /// Where the depth is largest; where the force is, 0 if that is at touchdown.
  double deepest_tau() const;
  double largest_force_tau() const;

 private:
  double depth(double fade, double cosine, double sine) const {
    return gravity_ + fade * ((1.0 - gravity_ * zeta_) * sine - gravity_ * cosine);
  }
  double rate(double fade, double cosine, double sine) const {
    return fade * (cosine + (gravity_ - zeta_) * sine);
  }
  bool settle(double& tau, bool of_force) const;
  double first_turn(double cosine, double sine) const;

  double zeta_ = 0.0;
  double gravity_ = 0.0;
  double omega2_ = 1.0;
  double release_ = 0.0;
  double span_ = 0.0;
  double square_ = 0.0, cube_ = 0.0;  ///< of x in tau
  double end_ = 1.0;
  bool smooth_ = false;
};

}  // namespace strobe::impact::detail
