// Least squares fit of surface line, scale and both legs' flight to one photograph.
// Part of the reduction, not of its interface. Thread-safe; no allocation.
#pragma once

#include <Eigen/Core>
#include <array>

#include "common/reduction/observations.hpp"

namespace strobe::reduction {

/// Unknowns: tilt [rad], height [m] and scale (about 1) against the levelling, then for each leg the position
/// and the velocity in the levelled photograph, at the leg's mean time, in metres and metres per span.
/// The equator's angle and spin of each leg, the other four of the fifteen, share no measurement with these.
inline constexpr int kTilt = 0;
inline constexpr int kHeight = 1;
inline constexpr int kScale = 2;
inline constexpr int kLegStart[2] = {3, 7};  // x, y, vx * span, vy * span
inline constexpr int kJointCount = 11;

using JointVector = Eigen::Matrix<double, kJointCount, 1>;
using JointMatrix = Eigen::Matrix<double, kJointCount, kJointCount>;

/// Time is measured from a leg's mean in units of its length, so that every column is of order one.
struct LegTime {
  bool fitted = false;
  double origin_s = 0.0;
  double span_s = 1.0;
  double first_s = 0.0;
  double last_s = 0.0;
  double scaled(double time_s) const { return (time_s - origin_s) / span_s; }
};

struct JointFit {
  JointVector unknowns = JointVector::Zero();
  JointMatrix covariance =
      JointMatrix::Zero();  ///< rows and columns of a leg that is not fitted mean nothing
  std::array<LegTime, 2> legs;
  Vec2 gravity_mps2;  ///< as used
};

constexpr std::size_t leg_index(Leg leg) { return leg == Leg::rebound ? 1 : 0; }

/// Gauss-Newton; the problem is linear but for products of small corrections. A leg with fewer than two
/// images is not fitted. Measured: converged to 1e-5 of an sd after two steps.
JointFit fit_joint(const Observations& all, Vec2 gravity_mps2);

/// Residual of an image's centre and its covariance before the fit, in the levelled photograph. [m, m^2]
struct CentreResidual {
  Vec2 residual;
  double cov_xx = 0.0;
  double cov_xy = 0.0;
  double cov_yy = 0.0;
};
CentreResidual centre_residual(const Observations& all, const JointFit& fit, const Observation& image);

/// Distance of a surface point from the fitted line. [m]
double surface_residual(const JointFit& fit, Vec2 point);

/// The part of the normal equations that measurements of one noise level contribute.
JointMatrix information(const Observations& all, const JointFit& fit, Noise noise);

}  // namespace strobe::reduction
