// A motion through the contact as a function of the time fraction, whatever it was computed by: pulse,
// contact ODE, or fitted curve. Thread-safe; making one copies its source and allocates.
#pragma once

#include <functional>

#include "common/contact/differentiation/constrained_motion.hpp"
#include "common/contact/integration/spin_pulse.hpp"
#include "common/impact/ode/contact_trajectory.hpp"

namespace strobe::contact {

struct TrajectoryPoint {
  double x_m = 0.0;           ///< displacement along the surface since touchdown
  double y_m = 0.0;           ///< height less that at touchdown: <= 0
  double rotation_rad = 0.0;  ///< since touchdown, counter-clockwise
};

/// Takes the time since touchdown over the dwell time: 0…1, and slightly outside of it, as measured images
/// are.
using Trajectory = std::function<TrajectoryPoint(double time_fraction)>;

Trajectory trajectory_of(const impact::SinePulse& pulse);  ///< friction throughout (thesis); rotation 0
Trajectory trajectory_of(const SpinPulse& pulse);
/// Over the ODE's own dwell time; outside of 0…1 the state at the nearer end.
Trajectory trajectory_of(const impact::ContactTrajectory& ode);
Trajectory trajectory_of(const ConstrainedMotion& motion);  ///< a spline that is absent counts as 0

}  // namespace strobe::contact
