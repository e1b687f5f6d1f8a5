// The cubic through measured places by another method in another arithmetic: Gauss–Jordan on the normal
// equations, in 100 digits.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <vector>

namespace strobe::testing {

// A design matrix of condition 1e12 squares to 1e24 in normal equations: of 100 digits 76 are left.
using Wide = boost::multiprecision::cpp_bin_float_100;

/// The cubic through (t, y) by least squares, with the residual sd, and G·Gᵀ of its coefficients.
struct WideCubicFit {
  std::array<Wide, 4> c{};
  std::array<std::array<Wide, 4>, 4> inverse{};
  Wide variance;
  Wide r2;

  WideCubicFit(const std::vector<double>& t, const std::vector<double>& y) {
    std::array<std::array<Wide, 9>, 4> m{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < t.size(); ++k) {
        for (std::size_t j = 0; j < 4; ++j) m[i][j] += pow(Wide(t[k]), static_cast<int>(i + j));
        m[i][4] += Wide(y[k]) * pow(Wide(t[k]), static_cast<int>(i));
      }
      m[i][5 + i] = 1;
    }
    for (std::size_t i = 0; i < 4; ++i) {  // positive definite: no pivoting needed
      const Wide pivot = m[i][i];
      for (Wide& value : m[i]) value /= pivot;
      for (std::size_t r = 0; r < 4; ++r) {
        if (r == i) continue;
        const Wide factor = m[r][i];
        for (std::size_t j = 0; j < 9; ++j) m[r][j] -= factor * m[i][j];
      }
    }
    for (std::size_t i = 0; i < 4; ++i) {
      c[i] = m[i][4];
      for (std::size_t j = 0; j < 4; ++j) inverse[i][j] = m[i][5 + j];
    }
    Wide mean = 0, residual = 0, total = 0;
    for (const double value : y) mean += Wide(value) / y.size();
    for (std::size_t k = 0; k < t.size(); ++k) {
      residual += pow(Wide(y[k]) - derivative(t[k], 0), 2);
      total += pow(Wide(y[k]) - mean, 2);
    }
    variance = residual / (t.size() - 4);
    r2 = 1 - residual / total;
  }

  static std::array<Wide, 4> row(const Wide& t, int order) {
    if (order == 0) return {1, t, t * t, t * t * t};
    if (order == 1) return {0, 1, 2 * t, 3 * t * t};
    return {0, 0, 2, 6 * t};
  }
  Wide derivative(double t, int order) const {
    const auto r = row(t, order);
    return r[0] * c[0] + r[1] * c[1] + r[2] * c[2] + r[3] * c[3];
  }
  Wide sd(double t, int order) const {
    const auto r = row(t, order);
    Wide sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) sum += r[i] * inverse[i][j] * r[j];
    return sqrt(sum * variance);
  }
  Wide standard_error(std::size_t coefficient) const {
    return sqrt(inverse[coefficient][coefficient] * variance);
  }
};

}  // namespace strobe::testing
