#include "host/thesis/contact_scale.hpp"

#include "common/contact/condition_inputs.hpp"

namespace strobe::report {

namespace {

double total_rotation_rad(const Material& material, const thesis::Condition& condition) {
  const auto course = course_of(material, condition);
  if (!course) return 0.0;
  const double own_rad = course->summary().rotation_rad;
  const contact::ContactSet& set = material.used.contact.at(condition.name());
  const auto score = contact::score(set, trajectory_of(*course), contact::set_scale(condition));
  if (!score || !score->rotation) return own_rad;
  const double fitted_rad = score->rotation->fitted_total.total_rad;
  return own_rad * fitted_rad > 0.0 ? own_rad : fitted_rad;
}

}  // namespace

contact::Trajectory trajectory_of(const impact::ContactTrajectory& course) {
  return [course](double t) {
    const impact::ContactState s = course.at(t * course.summary().dwell_s);
    return contact::TrajectoryPoint{s.x_m, s.y_m, s.angle_rad};
  };
}

contact::Scale scale_of(const Material& material, const thesis::Condition& condition) {
  return {.dwell_time_s = condition.dwell_time_ms.mean / 1e3,
          .dwell_distance_m = condition.dwell_distance_cm.mean / 1e2,
          .total_rotation_rad = total_rotation_rad(material, condition)};
}

}  // namespace strobe::report
