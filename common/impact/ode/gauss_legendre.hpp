// Gauss–Legendre collocation on 0…1: nodes, weights, integrals of the interpolating polynomial up to each
// node, and its Legendre coefficients. Computed by the compiler in long double, so that each entry is rounded
// once. Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.7.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>

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
  /// The nodes, the end, and where that makes an odd number the end again: even for instructions that take
  /// two.
  static constexpr std::size_t points = (n + 2) / 2 * 2;
  using Row = std::array<double, n>;
  using Points = std::array<double, points>;
  Row node{};
  Row weight{};
  /// Nodes, then 1.
  alignas(16) Points share{};
  /// integral[j][i]: what the value at node j adds to the integral from 0 to point i.
  alignas(16) std::array<Points, n> integral{};
  /// last[j][k]: coefficient[n - 4 + k][j].
  alignas(16) std::array<std::array<double, 4>, n> last{};
  /// coefficient[k][j]: what the value at node j adds to the coefficient of P_k(2c - 1); 0 beyond the nodes.
  alignas(16) std::array<Points, n> coefficient{};

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
    for (std::size_t i = 0; i < points; ++i) share[i] = i < n ? node[i] : 1.0;
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k)
        coefficient[k][j] =
            static_cast<double>(static_cast<long double>(2 * k + 1) * weights[j] * at[j].p[k]);
      for (std::size_t i = 0; i < n; ++i) {
        long double sum = 0.5L * (at[i].p[1] + 1.0L);
        for (std::size_t k = 1; k < n; ++k) sum += 0.5L * at[j].p[k] * (at[i].p[k + 1] - at[i].p[k - 1]);
        integral[j][i] = static_cast<double>(weights[j] * sum);
      }
      for (std::size_t i = n; i < points; ++i) integral[j][i] = static_cast<double>(weights[j]);
      for (std::size_t k = 0; k < 4; ++k) last[j][k] = coefficient[n - 4 + k][j];
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

/// P_(k+1) = up·t·P_k - down·P_(k-1); the integral of P_k over a share of 0…1 is integral·(P_(k+1) -
/// P_(k-1)).
template <std::size_t n>
struct LegendreRecurrence {
  std::array<double, n> up{}, down{}, integral{};
  constexpr LegendreRecurrence() {
    for (std::size_t k = 0; k < n; ++k) {
      const auto degree = static_cast<double>(k);
      up[k] = (2.0 * degree + 1.0) / (degree + 1.0);
      down[k] = degree / (degree + 1.0);
      integral[k] = 0.5 / (2.0 * degree + 1.0);
    }
  }
};

template <std::size_t n>
inline constexpr LegendreRecurrence<n> kRecurrence{};

/// Two numbers that one instruction of every processor that runs this takes at once; the order of sums is
/// fixed.
using Pair = double __attribute__((vector_size(16)));

inline Pair pair_at(const double* from) {
  Pair out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

/// The integrals from 0 to each point of the polynomial that has these values at the nodes.
template <std::size_t n>
inline void integrate_nodes(const typename GaussLegendre<n>::Points& value,
                            typename GaussLegendre<n>::Points& integral) {
  constexpr const GaussLegendre<n>& rule = kGaussLegendre<n>;
  constexpr std::size_t pairs = GaussLegendre<n>::points / 2;
  Pair sum[pairs] = {};
  for (std::size_t j = 0; j < n; ++j) {
    const Pair both{value[j], value[j]};
    for (std::size_t i = 0; i < pairs; ++i) sum[i] += pair_at(&rule.integral[j][2 * i]) * both;
  }
  for (std::size_t i = 0; i < pairs; ++i) std::memcpy(&integral[2 * i], &sum[i], sizeof sum[i]);
}

/// What each node's value adds to the integral from 0 to `share`.
template <std::size_t n>
inline void integral_weights(double share, typename GaussLegendre<n>::Points& weights) {
  constexpr const GaussLegendre<n>& rule = kGaussLegendre<n>;
  constexpr std::size_t pairs = GaussLegendre<n>::points / 2;
  const double t = 2.0 * share - 1.0;
  Pair sum[pairs];
  for (std::size_t i = 0; i < pairs; ++i) sum[i] = pair_at(&rule.coefficient[0][2 * i]) * share;
  double before = 1.0, at = t;
  for (std::size_t k = 1; k < n; ++k) {
    const double next = kRecurrence<n>.up[k] * (t * at) - kRecurrence<n>.down[k] * before;
    const double integral = kRecurrence<n>.integral[k] * (next - before);
    for (std::size_t i = 0; i < pairs; ++i) sum[i] += pair_at(&rule.coefficient[k][2 * i]) * integral;
    before = at;
    at = next;
  }
  for (std::size_t i = 0; i < pairs; ++i) std::memcpy(&weights[2 * i], &sum[i], sizeof sum[i]);
}

/// Its coefficients of P_(n-4) to P_(n-1).
template <std::size_t n>
inline std::array<double, 4> last_coefficients(const typename GaussLegendre<n>::Points& value) {
  constexpr const GaussLegendre<n>& rule = kGaussLegendre<n>;
  Pair low{}, high{};
  for (std::size_t j = 0; j < n; ++j) {
    const Pair both{value[j], value[j]};
    low += pair_at(&rule.last[j][0]) * both;
    high += pair_at(&rule.last[j][2]) * both;
  }
  return {low[0], low[1], high[0], high[1]};
}

}  // namespace strobe::impact::detail
