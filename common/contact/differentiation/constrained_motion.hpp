// The motion through the contact by constrained smoothing splines (constrained_spline.hpp), in SI units: the
// differentiation approach given the velocities of the airborne images besides. Pure; thread-safe; allocates.
#pragma once

#include <optional>

#include "common/contact/differentiation/constrained_spline.hpp"
#include "common/contact/differentiation/differentiation.hpp"

namespace strobe::contact {

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
/// mass. A spline is absent where fewer than three images are left for it. `no_force` also holds all three to
/// zero force (and torque) at both ends. Errors: those of check().
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
