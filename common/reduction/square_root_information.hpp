// Square-root information matrix of the joint fit: the upper triangular R of its whitened measurements, with
// R^T R = inverse covariance, in the blocks that the elimination leaves: each leg's own four unknowns, what couples them to tilt and scale, and
// the three that all share. Part of the reduction, not of its interface. Plain values; no allocation.
#pragma once

#include <array>
#include <cstddef>

namespace strobe::reduction {

/// Unknowns: tilt [rad], height [m] and scale (about 1) against the surface frame, then for each leg the position
/// and the velocity in the levelled photograph, at the leg's mean time, in metres and metres per span.
/// The equator's angle and spin of each leg, the other four of the fifteen, share no measurement with these.
inline constexpr std::size_t kTilt = 0;
inline constexpr std::size_t kHeight = 1;
inline constexpr std::size_t kScale = 2;
inline constexpr std::size_t kLegStart[2] = {3, 7};  // x, y, vx * span, vy * span
inline constexpr std::size_t kJointCount = 11;

using JointVector = std::array<double, kJointCount>;

/// Of whitened gradients: their numbers' covariance.
template <std::size_t N>
double dot(const std::array<double, N>& a, const std::array<double, N>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
  return sum;
}

/// An unknown without measurements has a zero row: no variance, no change. Eigen's triangular solvers would
/// divide by that zero, and sum in another order: readouts would change in their last digits.
struct SquareRootInformation {
  struct Leg {
    double r[4][4] = {};         ///< upper triangle
    double coupling[4][2] = {};  ///< columns: tilt, scale
  };
  Leg leg[2];
  double r[3][3] = {};  ///< upper triangle of tilt, height, scale

  /// R^-T g: the dot product of two such is the covariance of two numbers with gradients g.
  JointVector whitened(const JointVector& gradient) const;

  /// The same for a gradient by one leg's unknowns and by tilt and scale alone, as its images have:
  /// leg (4), tilt, height, scale.
  std::array<double, 7> whitened(std::size_t leg, const std::array<double, 6>& gradient) const;

  /// The same for a gradient by tilt, height and scale alone; the first four are zero.
  std::array<double, 7> shared(double by_tilt, double by_height, double by_scale) const;

  /// R^-1 y.
  JointVector unknowns(const JointVector& y) const;
};

}  // namespace strobe::reduction
