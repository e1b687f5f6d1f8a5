// Gauss–Legendre collocation on 0…1: nodes, weights, integrals of the interpolating polynomial up to each node,
// and its Legendre coefficients. Computed by the compiler in long double, so that each entry is rounded once.
// Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.7.
#pragma once

#include <array>
#include <cstddef>

namespace strobe::impact::detail {

/// P_0…P_n at t and dP_n/dt.
template <std::size_t n>
struct LegendreValues {
  std::array<long double, n + 1> p{};
  long double slope = 0.0L;
};

template <std::size_t n>
constexpr LegendreValues<n> legendre(long double t) {
  LegendreValues<n> out;
  out.p[0] = 1.0L;
  out.p[1] = t;
  for (std::size_t k = 1; k < n; ++k) {
    const auto degree = static_cast<long double>(k);
    out.p[k + 1] = ((2.0L * degree + 1.0L) * t * out.p[k] - degree * out.p[k - 1]) / (degree + 1.0L);
  }
  out.slope = static_cast<long double>(n) * (t * out.p[n] - out.p[n - 1]) / (t * t - 1.0L);
  return out;
}

template <std::size_t n>
struct GaussLegendre {
  using Row = std::array<double, n>;
  alignas(16) Row node{};
  alignas(16) Row weight{};
  /// integral[j][i]: what the value at node j adds to the integral from 0 to node i.
  alignas(16) std::array<Row, n> integral{};
  /// coefficient[k][j]: what the value at node j adds to the coefficient of P_k(2c - 1).
  alignas(16) std::array<Row, n> coefficient{};

  constexpr GaussLegendre() {
    std::array<LegendreValues<n + 1>, n> at{};
    std::array<long double, n> weights{};
    for (std::size_t i = 0; i < n; ++i) {
      const long double t = root(i);
      at[i] = legendre<n + 1>(t);
      const long double slope = legendre<n>(t).slope;
      weights[i] = 1.0L / ((1.0L - t * t) * slope * slope);
      node[i] = static_cast<double>(0.5L * (1.0L + t));
      weight[i] = static_cast<double>(weights[i]);
    }
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k)
        coefficient[k][j] =
            static_cast<double>(static_cast<long double>(2 * k + 1) * weights[j] * at[j].p[k]);
      for (std::size_t i = 0; i < n; ++i) {
        long double sum = 0.5L * (at[i].p[1] + 1.0L);
        for (std::size_t k = 1; k < n; ++k) sum += 0.5L * at[j].p[k] * (at[i].p[k + 1] - at[i].p[k - 1]);
        integral[j][i] = static_cast<double>(weights[j] * sum);
      }
    }
  }

 private:
  /// The i-th root of P_n, ascending, by Newton's method.
  static constexpr long double root(std::size_t i) {
    // A first guess, to some 1/n³ of the root.
    const long double angle = 3.14159265358979323846L * (static_cast<long double>(n - i) - 0.25L) /
                              (static_cast<long double>(n) + 0.5L);
    long double cosine = 0.0L, term = 1.0L;
    for (int k = 1; k < 40; k += 2) {
      cosine += term;
      term *= -angle * angle / static_cast<long double>(k * (k + 1));
    }
    for (int k = 0; k < 8; ++k) {
      const auto at = legendre<n>(cosine);
      cosine -= at.p[n] / at.slope;
    }
    return cosine;
  }
};

template <std::size_t n>
inline constexpr GaussLegendre<n> kGaussLegendre{};

}  // namespace strobe::impact::detail
