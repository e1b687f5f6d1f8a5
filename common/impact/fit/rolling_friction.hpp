// Rolling friction of a bounce from the balance of angular momentum alone: the normal force acts a distance d
// ahead of the centre,
//   alpha·R²·(omega_LO - omega_TD) = R·(vx_LO - vx_TD) + d·J,   J = (1 + e)|vy_TD|,
// independent of the friction and of whether the ball gripped. d/R is the coefficient of rolling friction:
// the moment d·N acts like a force (d/R)·N at the contact point. A footprint with equal pressure before and
// behind the centre has d = 0. Conventions as in rebound.hpp. Pure; thread-safe; copies the observation's
// names.
#pragma once

#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "common/impact/fit/observation.hpp"

namespace strobe::impact {

/// Offset along the direction of travel with a statistical sd, from the observation's standard deviations by
/// the delta method (touchdown and lift-off taken as independent), and a systematic one common to all
/// conditions, from alpha. d is proportional to the ball's diameter; d/R does not depend on it.
struct RollingFriction {
  std::string name;
  std::string spin;
  double offset_m = 0.0;  ///< d, positive ahead of the centre (towards +x)
  double offset_sd_m = 0.0;
  double offset_sd_alpha_m = 0.0;
  double offset_by_alpha_m = 0.0;  ///< derivative of d by alpha, signed
  double coefficient = 0.0;        ///< d/R
  double coefficient_sd = 0.0;
  double coefficient_sd_alpha = 0.0;
  double rolling_speed_mps = 0.0;  ///< (vx - R·omega)/2, mean of touchdown and lift-off
  /// d over its statistical sd; 0 for d = 0, infinite for another d whose sd is 0.
  double z_from_symmetry = 0.0;
};

/// alpha_sd >= 0, finite. Errors: not_finite (also for an sd that is negative or beyond kMaxMagnitude),
/// magnitude_out_of_range, not_approaching, restitution_out_of_range, ball_out_of_range.
tl::expected<RollingFriction, InputError> rolling_friction(const Observation& observation,
                                                           const ball::Ball& ball,
                                                           double alpha_sd = ball::kAlphaSd);

/// Over several conditions. Weights: 1 over the statistical variance; equal if any of those is 0.
struct RollingFrictionSummary {
  int count = 0;
  int positive = 0;        ///< of `count`
  double mean_m = 0.0;     ///< equally weighted
  double scatter_m = 0.0;  ///< sd between conditions (n - 1); 0 for one
  double weighted_mean_m = 0.0;
  double weighted_mean_sd_m = 0.0;  ///< statistical
  double mean_sd_alpha_m = 0.0;     ///< systematic, of both means
  double chi2_of_one_value = 0.0;   ///< of the weighted mean for all, count - 1 degrees of freedom
};

RollingFrictionSummary summarize(std::span<const RollingFriction> conditions);

}  // namespace strobe::impact
