// A check of invariants, for assertions. Pure; thread-safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace strobe::digitize {

/// Whether a matrix is symmetric and positive semi-definite but for rounding.
template <int n>
bool is_covariance(const cv::Matx<double, n, n>& m) {
  const double slack = 1e-9 * std::abs(cv::trace(m));
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < a; ++b)
      if (!(std::abs(m(a, b) - m(b, a)) <= slack)) return false;
  cv::Matx<double, n, 1> eigenvalues;
  cv::eigen(m, eigenvalues);
  return std::ranges::all_of(eigenvalues.val, [&](double value) { return value >= -slack; });
}

}  // namespace strobe::digitize
