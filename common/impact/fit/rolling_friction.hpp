// Rolling friction of a bounce, from the balance of angular momentum alone: the normal force stands a
// distance d ahead of the centre,
//   alpha·R²·(omega_LO - omega_TD) = R·(vx_LO - vx_TD) + d·J,   J = (1 + e)|vy_TD|,
// whatever the friction did and whether it gripped. d/R is the coefficient of rolling friction: the moment
// d·N brakes like a force (d/R)·N at the contact point. A footprint that presses alike before and behind the
// centre has d = 0. Conventions as in rebound.hpp. Pure; thread-safe. Only summarize() takes more than one.
#pragma once

#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "common/impact/fit/observation.hpp"

namespace strobe::impact {

/// How far alpha may be off: between the value measured on balls (.55) and that of the thesis's shell (.51).
inline constexpr double kAlphaSd = 0.04;

/// Offset along the direction of travel and its uncertainties, apart: statistical, from the observation's
/// standard deviations by the delta method (touchdown and lift-off as independent); systematic, common to all
/// conditions, from alpha. d is as uncertain as the ball's diameter (it goes with it); d/R does not depend on
/// it.
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
  /// Departure from a symmetric footprint (d = 0) in statistical sd; 0 where that sd is 0 and d is too,
  /// infinite where only the sd is.
  double z_from_symmetry = 0.0;
};

/// alpha_sd >= 0, finite. Errors: not_finite (also an sd that is negative or beyond kMaxMagnitude),
/// magnitude_out_of_range, not_approaching, restitution_out_of_range, ball_out_of_range.
tl::expected<RollingFriction, InputError> rolling_friction(const Observation& observation,
                                                           const ball::Ball& ball,
                                                           double alpha_sd = kAlphaSd);

/// Over several conditions. Weights: one over the statistical variance; all alike if any of those is 0.
struct RollingFrictionSummary {
  int count = 0;
  int positive = 0;        ///< of `count`
  double mean_m = 0.0;     ///< each condition alike
  double scatter_m = 0.0;  ///< sd between conditions (n - 1); 0 for one
  double weighted_mean_m = 0.0;
  double weighted_mean_sd_m = 0.0;    ///< statistical
  double mean_sd_alpha_m = 0.0;       ///< systematic, of both means
  double chi2_of_one_value = 0.0;     ///< of the weighted mean for all, count - 1 degrees of freedom
  double chi2_of_symmetry = 0.0;      ///< of d = 0 for all, count degrees of freedom
  double alpha_without_offset = 0.0;  ///< the alpha at which mean_m would be 0
};

RollingFrictionSummary summarize(std::span<const RollingFriction> conditions, double alpha);

}  // namespace strobe::impact
