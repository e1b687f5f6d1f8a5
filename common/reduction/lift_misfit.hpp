// What the paths' curvature says of the spins: the air lifts a ball with backspin and presses one with
// topspin down, whatever the equators leave open. Part of the reduction, not of its interface. Pure;
// thread-safe.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Between a leg's first and last image in use; 0 of fewer than two.
double mean_speed_mps(const Observations& all, std::size_t leg);

/// Lift over speed, as acceleration. [1/s]
double lift_per_s(const flight::Aerodynamics& air, double speed_mps, double omega_radps);

class LiftMisfit {
 public:
  /// Lifts as the images have them. Of a fit without lift nothing is known.
  explicit LiftMisfit(const ShotFit& fit);

  /// Of the lifts seen, given the spins before and after the bounce; absent: any. The lift coefficient is
  /// known to the law's share. 0 where nothing is known.
  double chi_squared(const std::array<std::optional<double>, 2>& omega_radps) const;

 private:
  bool known_ = false;
  flight::Aerodynamics air_;
  std::array<double, 2> speed_mps_{};
  Eigen::Vector2d seen_per_s_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Zero();
};

}  // namespace strobe::reduction
