// A smoothing spline through one contact fraction that takes the known positions and slopes at touchdown and
// lift-off (from the airborne images) exactly: what differentiation can reach when it is given all that is
// known. Quintic B-splines on uniform knots; the penalty is the integral of the squared third derivative (the
// change of the force). Its weight is chosen by generalized cross validation with each degree of freedom
// counted 1.4 times, or from a known noise by Mallows' Cp. The constraints are removed by an orthogonal basis
// of their null space, the rest is solved by QR.
// Sources: P. Craven and G. Wahba, Smoothing noisy data with spline functions, 1979; Y.-J. Kim and C. Gu,
// Smoothing spline Gaussian regression, 2004; P. Eilers and B. Marx, Flexible smoothing with B-splines and
// penalties, 1996. Pure; thread-safe; allocates; not for the real-time path.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "common/units/value_sd.hpp"

namespace strobe::contact {

/// What is known at touchdown (t = 0) and lift-off (t = 1), in the unit of the values. The slopes' sds widen
/// the bands; the values' are exact.
struct EndConditions {
  double value_td = 0.0;
  double value_lo = 0.0;
  ValueSd slope_td;
  ValueSd slope_lo;
  bool no_force_at_ends = false;  ///< second derivative 0 at both ends, as of a contact that starts and ends
};

struct SplineOptions {
  int intervals = 6;                ///< of the knots, 1…32
  std::optional<double> noise_sd;   ///< of one value; absent: estimated, and the weight chosen by GCV
  std::optional<double> smoothing;  ///< the weight, > 0; absent: chosen
};

class ConstrainedSpline {
 public:
  double value(double t) const { return derivative(t, 0); }
  double slope(double t) const { return derivative(t, 1); }
  double curvature(double t) const { return derivative(t, 2); }

  /// order 0…2; t is clamped to 0…1.
  double derivative(double t, int order) const { return derivative_with_sd(t, order).value; }

  /// Bayesian band (it includes the smoothing's bias on average) and the end slopes' sds.
  ValueSd derivative_with_sd(double t, int order) const;

  double smoothing() const { return smoothing_; }
  double residual_sd() const { return residual_sd_; }  ///< root of RSS/(n - effective parameters)
  int n() const { return n_; }

 private:
  friend class SplineFitter;
  int intervals_ = 0;
  std::vector<double> coefficients_;
  std::vector<double> covariance_factor_;  // G by columns: covariance of the coefficients = G·Gᵀ
  std::vector<double> end_slope_factor_;   // two columns: coefficients' change per sd of each end slope
  double smoothing_ = 0.0;
  double residual_sd_ = 0.0;
  int n_ = 0;
};

/// Fits the values y at the times t (interior images; what lies outside 0…1 is refused). Fails unless there
/// are as many t as y, at least three of them, all finite.
Result<ConstrainedSpline> fit_constrained_spline(std::span<const double> t, std::span<const double> y,
                                                 const EndConditions& ends,
                                                 const SplineOptions& options = {});

}  // namespace strobe::contact
