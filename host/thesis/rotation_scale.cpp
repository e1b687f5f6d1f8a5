#include "host/thesis/rotation_scale.hpp"

#include "common/contact/condition_inputs.hpp"
#include "common/contact/integration.hpp"

namespace strobe::report {

contact::Scale scale_of(const contact::ContactSet& set, const thesis::Condition& condition) {
  contact::Scale scale{.dwell_time_s = condition.dwell_time_ms.mean / 1e3,
                       .dwell_distance_m = condition.dwell_distance_cm.mean / 1e2};
  const auto pulse = contact::SpinPulse::make(contact::spin_pulse_input(condition, impact::PulseForm::exact));
  if (!pulse) return scale;
  const auto score = contact::score(set, contact::trajectory_of(*pulse), contact::set_scale(condition));
  scale.total_rotation_rad =
      score && score->rotation ? score->rotation->fitted_total.total_rad : pulse->total_rotation_rad();
  return scale;
}

}  // namespace strobe::report
