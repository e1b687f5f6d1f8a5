// Least squares of a cubic polynomial: the thesis's differentiation approach fits one to each contact
// fraction. Solved by QR with column pivoting in u = (t - centre)/half_width, which keeps the digits of times
// that lie close together or far from zero; the coefficients in powers of t follow from those in u. Pure;
// thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "common/result.hpp"
#include "common/units/value_sd.hpp"

namespace strobe::contact {

/// 2-norm condition numbers of the design matrix.
struct DesignCondition {
  double monomial = 0.0;  ///< columns 1, t, t², t³ as the thesis has them
  double scaled = 0.0;    ///< the same columns, each of unit length
  double centred = 0.0;   ///< powers of u, as solved
};

class CubicFit {
 public:
  std::array<double, 4> coefficients{};  ///< of powers of t, constant first
  /// Of each coefficient, residual variance with n - 4 degrees of freedom; absent for n = 4.
  std::optional<std::array<double, 4>> standard_errors;
  /// 1 - residual over total sum of squares; absent when all values are equal.
  std::optional<double> r_squared;
  int n = 0;
  std::optional<double> residual_sd;  ///< root of the residual variance; absent for n = 4
  DesignCondition condition;

  double value(double t) const { return derivative(t, 0); }
  double slope(double t) const { return derivative(t, 1); }
  double curvature(double t) const { return derivative(t, 2); }
  double derivative(double t, int order) const;  ///< order 0…3

  /// The sd is propagated from the residuals: it holds if they are noise and the curve is a cubic; 0 for n =
  /// 4.
  ValueSd derivative_with_sd(double t, int order) const;

 private:
  friend Result<CubicFit> fit_cubic(std::span<const double> t, std::span<const double> y);
  std::array<double, 4> local_{};               // of powers of u
  std::array<double, 16> covariance_factor_{};  // G by rows: covariance of local_ = residual_sd²·G·Gᵀ
  double centre_ = 0.0;
  double half_width_ = 1.0;
};

/// Fits value(t[i]) to y[i]. Fails unless there are as many t as y, all finite, with four different t among
/// them (so far apart that the coefficients can be told from each other in double precision), and of a size
/// that leaves coefficients and sums of squares within double precision.
Result<CubicFit> fit_cubic(std::span<const double> t, std::span<const double> y);

}  // namespace strobe::contact
