#include "host/thesis/contact_scale.hpp"

#include "common/contact/condition_inputs.hpp"

namespace strobe::report {

namespace {

double total_rotation_rad(const ThesisInputs& inputs, const thesis::Condition& condition) {
  const auto ode = simulate_contact(inputs, condition);
  if (!ode) return 0.0;
  const double own_rad = ode->summary().rotation_rad;
  const data::ContactSet& set = inputs.used.contact.at(condition.name());
  const auto errors =
      contact::standard_errors(set, contact::trajectory_of(*ode), contact::fraction_scale(condition));
  if (!errors || !errors->rotation) return own_rad;
  const double fitted_rad = errors->rotation->fitted_total.total_rad;
  return own_rad * fitted_rad > 0.0 ? own_rad : fitted_rad;
}

}  // namespace

contact::ContactScale contact_scale(const ThesisInputs& inputs, const thesis::Condition& condition) {
  return {.dwell_time_s = condition.dwell_time_ms.mean / 1e3,
          .dwell_distance_m = condition.dwell_distance_cm.mean / 1e2,
          .total_rotation_rad = total_rotation_rad(inputs, condition)};
}

}  // namespace strobe::report
