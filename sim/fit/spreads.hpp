// The spreads of restitution, grip and offset that make, with a tablet's noise and the machine's spread, the
// published standard deviations at lift-off. Implementation of fit.hpp, which gives the derivation. Pure;
// thread-safe; allocates.
#pragma once

#include "sim/scene/scene.hpp"

namespace strobe::sim {

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
