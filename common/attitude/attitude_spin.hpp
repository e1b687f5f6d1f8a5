// The spin vector from whole attitudes at known times. A ball without moments on it turns about one axis at
// one rate, attitude(t) = rotation(spin·(t - t0))·attitude(t0). What real ones do besides may be fitted with
// it: air takes spin, exp(-decay·(t - t0)), and a ball whose moments of inertia differ by some share wobbles:
// a symmetric top turns about its angular momentum and, at some thousandths of that rate, about an axis of
// its own (Goldstein, Classical Mechanics, ch. 5.6), so that attitude(t) =
// rotation(spin·s)·rotation(wobble·(t - t0))·attitude(t0), s the integral of the decay. Least squares on
// SO(3) by Gauss-Newton on rotation vectors; pairs of attitudes start it, each with all whole turns that the
// fastest spin allows, and each start grows from image to image as long as the next attitude is where it is
// expected, so that outliers and wrong turns fall out. Axes right-handed; a rotation vector's length is the
// angle [rad]. Deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/result.hpp"

namespace strobe::attitude {

/// Rodrigues' formula.
Eigen::Matrix3d rotation(const Eigen::Vector3d& vector_rad);
/// Its inverse, of length 0 to pi. `rotation` must be orthonormal.
Eigen::Vector3d rotation_vector_rad(const Eigen::Matrix3d& rotation);

struct TimedAttitude {
  double time_s = 0.0;
  Eigen::Matrix3d attitude;  ///< from the ball's axes to the picture's
  /// Of the rotation vector, in the picture's axes, that leads from the truth to `attitude`; positive
  /// definite.
  Eigen::Matrix3d covariance_rad2;
};

struct SpinSearch {
  double fastest_spin_radps = 0.0;  ///< > 0
  double decay_sd_per_s = 0.0;      ///< prior of the decay about none; 0: there is none
  double wobble_sd = 0.0;           ///< prior of the wobble's components as a share of the spin; 0: none
};

struct SpinFit {
  Eigen::Vector3d spin_radps;  ///< at the reference time, without the wobble
  /// Times the reduced chi squared where that is above one: the attitudes then scatter more than stated.
  Eigen::Matrix3d covariance_radps2;
  double reference_time_s = 0.0;  ///< mean of those used
  Eigen::Matrix3d attitude;       ///< at that time
  double decay_per_s = 0.0, decay_sd_per_s = 0.0;
  /// Across the spin, in the picture's axes at the reference time; fixed in the ball.
  Eigen::Vector3d wobble_radps;
  Eigen::Matrix3d wobble_covariance_radps2;
  double chi_squared = 0.0;  ///< of those used, by the stated covariances
  int degrees_of_freedom = 0;
  std::vector<bool> used;                      ///< one for each attitude; false: an outlier
  std::vector<Eigen::Vector3d> residuals_rad;  ///< measured less fitted, of all, in the order given

  Eigen::Matrix3d attitude_at(double time_s) const;
};

inline constexpr std::size_t kMaxAttitudes = 1000;

/// The best fit first, then all others that explain the attitudes nearly as well (up to a thousand times less
/// likely): with even steps in time, those that make whole turns more from one image to the next. Of equally
/// good ones the slowest is first. Fails with one line for fewer than two attitudes or more than
/// kMaxAttitudes, two at one time, numbers that are not finite or none, and where no two agree below the
/// fastest spin.
Result<std::vector<SpinFit>> fit_spin(std::span<const TimedAttitude> attitudes, const SpinSearch& search);

}  // namespace strobe::attitude
