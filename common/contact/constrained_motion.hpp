// The motion through the contact by constrained smoothing splines: quintic B-splines on uniform knots over
// 0…1 (C. de Boor, A Practical Guide to Splines, chapter X). Pure; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <span>
#include <vector>

#include "common/contact/differentiation.hpp"
#include "common/result.hpp"
#include "common/units/value_sd.hpp"

namespace strobe::contact {

inline constexpr int kSplineDegree = 5;

/// Values at t (0…1) of the `order`-th derivative (0…3) of the intervals + 5 basis functions.
Eigen::RowVectorXd spline_row(int intervals, double t, int order);

/// Matrix D with |D·c|² = integral over 0…1 of the squared third derivative (exact: three-point Gauss rule).
Eigen::MatrixXd roughness_factor(int intervals);

// A smoothing spline through one contact fraction that takes the known positions and slopes at touchdown and
// lift-off (from the airborne images) exactly: what differentiation can reach when it is given all that is
// known. Quintic B-splines on uniform knots; the penalty is the integral of the squared third derivative (the
// change of the force). Its weight is chosen by generalized cross validation with each degree of freedom
// counted 1.4 times, or from a known noise by Mallows' Cp. The constraints are removed by an orthogonal basis
// of their null space, the rest is solved by QR.
// Sources: P. Craven and G. Wahba, Smoothing noisy data with spline functions, 1979; Y.-J. Kim and C. Gu,
// Smoothing spline Gaussian regression, 2004; P. Eilers and B. Marx, Flexible smoothing with B-splines and
// penalties, 1996. Pure; thread-safe; allocates; not for the real-time path.

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

  /// Bayesian band (it includes the smoothing's bias on average) and the end slopes' sds. The sd is 0 where
  /// it is not known: the weight was chosen such that the images tell less than half a degree of freedom, or
  /// leave none.
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
/// are as many t as y, three different t at least, all finite.
Result<ConstrainedSpline> fit_constrained_spline(std::span<const double> t, std::span<const double> y,
                                                 const EndConditions& ends,
                                                 const SplineOptions& options = {});

// The motion through the contact by these splines, in SI units: the
// differentiation approach given the velocities of the airborne images besides. Pure; thread-safe; allocates.

/// Velocities on either side of the contact, measured in the air.
struct EndVelocities {
  ValueSd vx_td_mps, vx_lo_mps, vy_td_mps, vy_lo_mps, omega_td_radps, omega_lo_radps;
};

struct ConstrainedMotion {
  std::optional<ConstrainedSpline> x, y, rotation;  ///< m, m, rad as functions of the time fraction
  ContactScale scale;
};

/// Fails on a dwell time, distance, diameter or mass that is not positive, or a rotation that is not finite.
Result<void> check(const ContactScale& scale);

/// Fits the images between the end points within 0…1. y is the top of the ball, which is not the centre of
/// mass. A spline is absent where the images left for it are at fewer than three times. `no_force` also holds
/// all three to zero force (and torque) at both ends. Errors: those of check().
Result<ConstrainedMotion> fit_constrained_motion(const data::ContactSet& set, const ContactScale& scale,
                                                 const EndVelocities& ends, bool no_force = true,
                                                 const SplineOptions& options = {});

DerivedState derive(const ConstrainedMotion& motion, double time_fraction);

/// Largest normal force of the spline, of 0…1 in steps of 1/1000.
struct ForcePeak {
  ValueSd force_n;
  double fraction = 0.0;
};
std::optional<ForcePeak> largest_normal_force(const ConstrainedMotion& motion);

}  // namespace strobe::contact
