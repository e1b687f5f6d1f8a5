// The thesis's differentiation approach: a cubic polynomial fitted to each contact fraction by least squares.
// Solved by QR with column pivoting in u = (t - centre)/half_width, which keeps the digits of times that lie
// close together or far from zero; the coefficients in powers of t follow from those in u. Pure; thread-safe;
// allocates.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/data/contact_set.hpp"
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
  /// Of each coefficient, residual variance with n - 4 degrees of freedom; absent for n = 4 and where the
  /// residuals are rounding: nothing then tells how uncertain the values are.
  std::optional<std::array<double, 4>> standard_errors;
  /// 1 - residual over total sum of squares; absent when all values are equal.
  std::optional<double> r_squared;
  int n = 0;
  std::optional<double> residual_sd;  ///< root of the residual variance; absent as the standard errors
  DesignCondition condition;

  double value(double t) const { return derivative(t, 0); }
  double slope(double t) const { return derivative(t, 1); }
  double curvature(double t) const { return derivative(t, 2); }
  double derivative(double t, int order) const;  ///< order 0…3

  /// The sd is propagated from the residuals: it holds if they are noise and the curve is a cubic; 0 without
  /// a residual sd.
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

// The differentiation approach: cubics through the contact fractions, derived to velocities, forces and
// torque with standard deviations; the velocities they give at touchdown and lift-off; where spin and slip
// pass through zero; and how the relative error grows from position to velocity to force, which is why the
// thesis left this approach. Scales: x by the dwell distance, y by the diameter, rotation by the total
// rotation, each over the dwell time once per derivative. The sds are those of the fit alone (see CubicFit),
// not of the scales. Pure; thread-safe; what returns vectors or fits allocates.

/// Cubics of each fraction on the time fraction over all rows, the end points included; rows without a
/// rotation are left out of that fit. Absent where the rows do not determine it.
struct FractionFits {
  std::optional<CubicFit> x;
  std::optional<CubicFit> y;
  std::optional<CubicFit> rotation;
};

FractionFits fit_fractions(const data::ContactSet& set);

/// Turns fractions per time fraction into velocities and forces.
struct ContactScale {
  double dwell_time_s = 0.0;  ///< > 0
  double dwell_distance_m = 0.0;
  double total_rotation_rad = 0.0;  ///< angle at lift-off less that at touchdown
  double diameter_m = ball::kThesisDiameter_m;
  double mass_kg = ball::kThesisMass_kg;
  double alpha = ball::kMeasuredAlpha;  ///< for the torque only

  double inertia_kgm2() const {
    return ball::Ball{.diameter_m = diameter_m, .mass_kg = mass_kg, .alpha = alpha}.inertia_kgm2();
  }
};

/// What needs an absent fit is absent. vy is y'·D/dwell (the thesis's table has half of it). A cubic's force
/// neither starts nor ends at zero.
struct DerivedState {
  std::optional<ValueSd> x_m, y_m, rotation_rad;
  std::optional<ValueSd> vx_mps, vy_mps, omega_radps;
  std::optional<ValueSd> fx_n, fy_n, torque_nm;  ///< m·a, alpha·m·R²·(domega/dt) about the centre
  std::optional<ValueSd> slip_mps;               ///< vx + R·omega, the two fits taken as independent
};

/// Slip of the contact point from vx and omega, their errors taken as independent. Returns nullopt without
/// both.
std::optional<ValueSd> slip_of(const DerivedState& state, double radius_m);

DerivedState derive(const FractionFits& fits, const ContactScale& scale, double time_fraction);

/// Velocities, forces and torque as polynomials of the time fraction, constant first: the thesis's Table 12
/// in real units (its own is per unit of fraction: see fraction_polynomials()).
struct DerivedPolynomials {
  std::optional<std::array<double, 3>> vx_mps, vy_mps, omega_radps;
  std::optional<std::array<double, 2>> fx_n, fy_n, torque_nm;
};

DerivedPolynomials derived_polynomials(const FractionFits& fits, const ContactScale& scale);

/// The same with all scales 1: derivatives of the fractions by the time fraction.
DerivedPolynomials fraction_polynomials(const FractionFits& fits);

/// Time fractions in 0…1, in order, at which the fitted curves pass through zero (touchdown itself left out).
/// The thesis's Table 14 asks where the rotation is zero; skidding stops where the slip is.
struct ZeroCrossings {
  std::vector<double> rotation;  ///< the angle is that of touchdown again
  std::vector<double> omega;     ///< the spin changes its sense
  std::vector<double> slip;      ///< vx + R·omega = 0
};

ZeroCrossings zero_crossings(const FractionFits& fits, const ContactScale& scale);

/// Roots of c0 + c1·t + c2·t² in [low, high], in order; a double root once; none if all coefficients are 0.
std::vector<double> quadratic_roots(const std::array<double, 3>& c, double low, double high);

/// Root mean square over the contact of the sd, over that of the quantity itself: the relative error of each
/// derivative of one fit.
struct ErrorGrowth {
  double position = 0.0;
  double velocity = 0.0;
  double force = 0.0;
  double force_at_ends = 0.0;  ///< the larger of the force's sds at touchdown and lift-off, over the same rms
};

/// Returns nullopt for a fit without a residual sd and for a curve that is zero.
std::optional<ErrorGrowth> error_growth(const CubicFit& fit);

}  // namespace strobe::contact
