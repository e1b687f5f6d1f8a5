// The motion through the contact by constrained smoothing splines (constrained_fit.hpp), in real units: the
// differentiation approach given what the airborne images know besides. And how well each approach foretells
// an image that it was not shown. Pure; thread-safe; allocates.
#pragma once

#include <optional>

#include "common/contact/differentiation/constrained_fit.hpp"
#include "common/contact/differentiation/differentiation.hpp"
#include "common/contact/integration/integration.hpp"

namespace strobe::contact {

/// Velocities on either side of the contact, measured in the air.
struct EndVelocities {
  ValueSd vx_td_mps, vx_lo_mps, vy_td_mps, vy_lo_mps, omega_td_radps, omega_lo_radps;
};

struct ConstrainedMotion {
  std::optional<ConstrainedFit> x, y, rotation;  ///< m, m, rad as functions of the time fraction
  Scale scale;
};

/// Interior images within 0…1. y is the top of the ball, which is not the centre of mass. A fit is absent
/// where fewer than three images are left for it. `no_force` also holds x and y to zero force at both ends.
/// Fails on a dwell time, distance, diameter or mass that is not positive.
Result<ConstrainedMotion> fit_constrained_motion(const ContactSet& set, const Scale& scale,
                                                 const EndVelocities& ends, bool no_force = true,
                                                 const ConstrainedFitOptions& options = {});

DerivedState derive(const ConstrainedMotion& motion, double time_fraction);

Trajectory trajectory_of(const ConstrainedMotion& motion);  ///< absent fits count as zero
Trajectory trajectory_of(const FractionFits& fits, const Scale& scale);

/// Largest normal force of the spline, of 0…1 in steps of 1/1000.
struct ForcePeak {
  ValueSd force_n;
  double fraction = 0.0;
};
std::optional<ForcePeak> largest_normal_force(const ConstrainedMotion& motion);

/// Root mean square error of each interior image, foretold without it. The cubic and the spline are fitted
/// anew for each (the spline's weight chosen anew), the cubic with the end points; the pulse has not seen the
/// images anyway. `none`: not enough images.
struct LeaveOneOut {
  std::optional<double> cubic, spline, pulse;
};

struct CrossValidation {
  LeaveOneOut x_m, y_m, rotation_rad;
  int n = 0;
};

/// Over the interior images within 0…1; rotations with the scale's total. Errors as fit_constrained_motion().
Result<CrossValidation> leave_one_out(const ContactSet& set, const Scale& scale, const EndVelocities& ends,
                                      const Trajectory& pulse, bool no_force = true,
                                      const ConstrainedFitOptions& options = {});

}  // namespace strobe::contact
