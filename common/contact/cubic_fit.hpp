// Least squares of a cubic polynomial: the thesis's differentiation approach fits one to each contact
// fraction. Solved by QR with column pivoting, not by normal equations. Pure; thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "common/result.hpp"

namespace strobe::contact {

struct CubicFit {
  std::array<double, 4> coefficients{};  ///< constant first
  /// Of each coefficient, residual variance with n - 4 degrees of freedom; absent for n = 4.
  std::optional<std::array<double, 4>> standard_errors;
  std::optional<double>
      r_squared;  ///< 1 - residual over total sum of squares; absent when all values are equal
  int n = 0;

  double value(double t) const;
  double slope(double t) const;      ///< first derivative
  double curvature(double t) const;  ///< second derivative
};

/// Fits value(t[i]) to y[i]. Fails unless there are as many t as y, all finite, with four different t among
/// them (so far apart that the coefficients can be told from each other in double precision).
Result<CubicFit> fit_cubic(std::span<const double> t, std::span<const double> y);

}  // namespace strobe::contact
