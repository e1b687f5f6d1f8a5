#include "common/contact/mechanics_score.hpp"

namespace strobe::contact {

Trajectory trajectory_of(const impact::ContactTrajectory& course) {
  return [course](double time_fraction) {
    const impact::ContactState s = course.at(time_fraction * course.summary().dwell_s);
    return TrajectoryPoint{s.x_m, s.y_m, s.angle_rad};
  };
}

Result<MechanicsScore> score_mechanics(const ContactSet& set, const ball::Ball& ball,
                                       const impact::Motion& touchdown,
                                       const impact::ContactCoefficients& coefficients,
                                       const SetScale& scale) {
  const auto course = impact::ContactTrajectory::make(ball, touchdown, coefficients);
  if (!course) return fail(std::string(impact::message(course.error())));
  const auto held = score(set, trajectory_of(*course), scale);
  if (!held) return tl::unexpected(held.error());
  return MechanicsScore{*held, course->summary()};
}

}  // namespace strobe::contact
