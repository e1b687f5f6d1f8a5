// Order statistics of a few numbers. Pure; thread-safe; allocates.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace strobe::digitize {

/// The sd of a normal sample over the median of its absolute deviations.
inline constexpr double kSdOverMad = 1.4826;
/// The sd of a normal sample's median over that of its mean: the root of pi / 2.
inline constexpr double kSdOfMedian = 1.2533;

/// Where the biweight ends: 95 % efficient on normal errors, and blind to what is farther out (Beaton and
/// Tukey, Technometrics 16, 1974).
inline constexpr double kBiweightReach_sd = 4.685;

/// What is further off than this is something else: of normal errors one in 16,000 is.
inline constexpr double kFarthest_sd = 4.0;
/// What is further off than this may be something else: of normal errors one in 370 is.
inline constexpr double kDoubtful_sd = 3.0;
/// How much likelier one explanation must be than the next to be believed: a thousand to one, as a logarithm
/// of likelihoods.
inline constexpr double kThousandToOne = 3.0 * std::numbers::ln10;

/// The value that `numerator` / `denominator` of the others, rounded down, do not exceed: without
/// interpolation, so that the median of an even number of values is the upper one. Returns 0 for no values.
template <typename Number>
Number quantile(std::vector<Number> values, std::size_t numerator, std::size_t denominator) {
  if (values.empty()) return Number{};
  const auto rank = static_cast<std::ptrdiff_t>(values.size() * numerator / denominator);
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

template <typename Number>
Number upper_median(std::vector<Number> values) {
  return quantile(std::move(values), 1, 2);
}

/// The mean of the middle two of an even number. Returns 0 for no values.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// Of values and their weights, > 0. Returns 0 for none.
inline double weighted_median(std::vector<std::pair<double, double>> values) {
  std::ranges::sort(values);
  double total = 0.0;
  for (const auto& [value, weight] : values) total += weight;
  double sum = 0.0;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= 0.5 * total) return value;
  }
  return 0.0;
}

// A check of invariants, for assertions. Pure; thread-safe.

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
