// A leg where its numbers are told, with derivatives by everything it hangs on. Part of the reduction, not of
// its interface. Plain values and pure functions; thread-safe.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Forward-mode differentiation: a number together with its derivatives by N variables. Each rule is the
/// chain rule, so a readout written once as a formula gives its exact gradient for the propagation of errors.
template <std::size_t N>
struct Dual {
  double value = 0.0;
  std::array<double, N> grad{};

  constexpr Dual() = default;
  constexpr Dual(double v) : value(v) {}  // NOLINT: a constant: no derivatives

  static constexpr Dual variable(double v, std::size_t index) {
    Dual d(v);
    d.grad[index] = 1.0;
    return d;
  }
};

/// f(a), given its derivative df/da.
template <std::size_t N>
Dual<N> chain(const Dual<N>& a, double f, double df_da) {
  Dual<N> r(f);
  for (std::size_t i = 0; i < N; ++i) r.grad[i] = df_da * a.grad[i];
  return r;
}

/// f(a, b), given its derivatives df/da and df/db.
template <std::size_t N>
Dual<N> chain(const Dual<N>& a, const Dual<N>& b, double f, double df_da, double df_db) {
  Dual<N> r(f);
  for (std::size_t i = 0; i < N; ++i) r.grad[i] = df_da * a.grad[i] + df_db * b.grad[i];
  return r;
}

// clang-format off
template <std::size_t N> Dual<N> operator-(const Dual<N>& a) { return chain(a, -a.value, -1.0); }
template <std::size_t N> Dual<N> operator+(const Dual<N>& a, const Dual<N>& b) { return chain(a, b, a.value + b.value, 1.0, 1.0); }
template <std::size_t N> Dual<N> operator-(const Dual<N>& a, const Dual<N>& b) { return chain(a, b, a.value - b.value, 1.0, -1.0); }
template <std::size_t N> Dual<N> operator*(const Dual<N>& a, const Dual<N>& b) { return chain(a, b, a.value * b.value, b.value, a.value); }
template <std::size_t N> Dual<N> operator/(const Dual<N>& a, const Dual<N>& b) { return chain(a, b, a.value / b.value, 1.0 / b.value, -(a.value / b.value) / b.value); }
template <std::size_t N> Dual<N> operator+(const Dual<N>& a, double b) { return chain(a, a.value + b, 1.0); }
template <std::size_t N> Dual<N> operator-(const Dual<N>& a, double b) { return chain(a, a.value - b, 1.0); }
template <std::size_t N> Dual<N> operator*(const Dual<N>& a, double b) { return chain(a, a.value * b, b); }
template <std::size_t N> Dual<N> operator/(const Dual<N>& a, double b) { return chain(a, a.value / b, 1.0 / b); }
template <std::size_t N> Dual<N> operator*(double a, const Dual<N>& b) { return b * a; }
template <std::size_t N> Dual<N> operator-(double a, const Dual<N>& b) { return chain(b, a - b.value, -1.0); }
// clang-format on

template <std::size_t N>
Dual<N> abs(const Dual<N>& a) {
  return a.value < 0.0 ? -a : a;
}

template <std::size_t N>
Dual<N> sqrt(const Dual<N>& a) {
  const double root = std::sqrt(a.value);
  return chain(a, root, 0.5 / root);
}

template <std::size_t N>
Dual<N> hypot(const Dual<N>& a, const Dual<N>& b) {
  const double length = std::hypot(a.value, b.value);
  if (length == 0.0) return Dual<N>(0.0);
  return chain(a, b, length, a.value / length, b.value / length);
}

template <std::size_t N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  // Divided by the length twice, since its square may leave double precision's range.
  const double length = std::hypot(x.value, y.value);
  if (length == 0.0) return Dual<N>(0.0);
  return chain(y, x, std::atan2(y.value, x.value), x.value / length / length, -y.value / length / length);
}

// Variables of the derivatives: the joint fit's unknowns, both spins, the ball's diameter, the spin's decay,
// the errors of the air, and the instants of touchdown and lift-off. The latter hang on the others: they tell
// what of a number does so through them.
inline constexpr std::size_t kSpin[2] = {kJointCount, kJointCount + 1};
inline constexpr std::size_t kDiameter = kJointCount + 2;
inline constexpr std::size_t kDecay = kJointCount + 3;
inline constexpr std::size_t kAir = kJointCount + 4;  // the first of AirErrors
inline constexpr std::size_t kInstant[2] = {kAir + kAirErrorCount, kAir + kAirErrorCount + 1};
using Number = Dual<kAir + kAirErrorCount + 2>;
using Response = decltype(Number::grad);

/// A leg where its centre is one radius above the surface, in the surface's axes. Of a photograph without a
/// surface: at the first image in use, in the photograph's.
struct SurfaceCrossing {
  Number time_s;
  Number x_m;
  Number vx_mps;
  Number vy_mps;
};

/// The ball's, half of its diameter.
Number radius(const ShotFit& fit);

/// Of one leg about its origin of time in the surface's axes; the height is less a radius.
flight::Flight flight_of(const ShotFit& fit, std::size_t leg);

/// Returns nullopt if the leg is not fitted, or does not meet the surface, if there is one, in its direction.
std::optional<SurfaceCrossing> crossing(const ShotFit& fit, std::size_t leg);

/// How a fit follows its images' times, to first order: of each image, in the observations' order, the
/// derivatives of the variables of Number by its time. [1/s]
///
/// An image whose flash came later by dt is one that lies v dt nearer, and is turned omega dt less: the fit
/// answers as to noise of the image, x by the covariance times J^T W v, spin and the air's errors likewise.
/// Left out are products with residuals, and what the spin's change does to the lift: a thousandth of it.
/// Source: Gauss-Newton's step, e.g. Bjorck, Numerical Methods for Least Squares Problems, 9.2.
std::vector<Response> time_response(const ShotFit& fit);

}  // namespace strobe::reduction
