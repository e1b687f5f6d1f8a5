// Coefficients with which a ball without spread rebounds with a condition's means, as closely as the
// contact's mechanics allow. Implementation of fit.hpp, which gives the derivation. Pure; thread-safe;
// allocates.
#pragma once

#include "common/data/thesis_data.hpp"
#include "common/result.hpp"
#include "sim/motion/contact_path.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// Lift-off of the scene's mean ball.
Result<LiftOff> mean_lift_off(const Scene& scene);

/// Sets e, dwell time, mu, stiffness_ratio, damping_ratio and offset_share of a scene whose machine throws as
/// the condition's balls came in. Fails if the condition is outside the contact's ranges.
Result<void> fit_coefficients(Scene& scene, const thesis::Condition& condition);

// The spreads of restitution, grip and offset that make, with a tablet's noise and the machine's spread, the
// published standard deviations at lift-off. Implementation of fit.hpp, which gives the derivation. Pure;
// thread-safe; allocates.

inline double square(double x) { return x * x; }

/// Of velocities and spin at lift-off, SI.
struct LiftOffVariances {
  double vx = 0.0;
  double vy = 0.0;
  double spin = 0.0;
};

/// Sets e_sd, mu_sd or stiffness_ratio_sd, offset_share_sd and offset_grip_correlation of a scene whose means
/// and machine are set. Returns the variances that are to be expected then.
LiftOffVariances fit_spreads(Scene& scene, const LiftOffVariances& noise, const LiftOffVariances& published);

}  // namespace strobe::sim
