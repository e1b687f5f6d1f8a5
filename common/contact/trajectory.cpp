#include "common/contact/trajectory.hpp"

namespace strobe::contact {

Trajectory trajectory_of(const impact::SinePulse& pulse) {
  return [pulse](double time_fraction) {
    const impact::PulseState s = pulse.at_fraction(time_fraction);
    return TrajectoryPoint{s.x_m, s.y_m, 0.0};
  };
}

Trajectory trajectory_of(const SpinPulse& pulse) {
  return [pulse](double time_fraction) {
    const SpinPulseState s = pulse.at_fraction(time_fraction);
    return TrajectoryPoint{s.x_m, s.y_m, s.rotation_rad};
  };
}

Trajectory trajectory_of(const impact::ContactTrajectory& ode) {
  return [ode](double time_fraction) {
    const impact::ContactState s = ode.at(time_fraction * ode.summary().dwell_s);
    return TrajectoryPoint{s.x_m, s.y_m, s.rotation_rad};
  };
}

Trajectory trajectory_of(const ConstrainedMotion& motion) {
  return [motion](double time_fraction) {
    const auto value = [&](const std::optional<ConstrainedSpline>& spline) {
      return spline ? spline->value(time_fraction) : 0.0;
    };
    return TrajectoryPoint{value(motion.x), value(motion.y), value(motion.rotation)};
  };
}

}  // namespace strobe::contact
