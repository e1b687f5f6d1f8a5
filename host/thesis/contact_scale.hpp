// What turns a set's fractions into real units. Pure; thread-safe.
#pragma once

#include "common/contact/differentiation/analysis.hpp"
#include "common/contact/integration/integration.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::report {

/// The mechanics' motion over the time fraction, to be scored against images.
contact::Trajectory trajectory_of(const impact::ContactTrajectory& course);

/// Dwell time and distance are the condition's. The total rotation is not printed: it is the one that the
/// contact's mechanics gives, which was fitted to velocities and spins alone; where the images turn the other
/// way (back_17, whose total is near zero), the one with which they fit the mechanics best. Where the
/// thesis's own can be told, from the corrected entries of its Table 13, it is -51.0 degrees (zero_23) and
/// -9.7 (back_22); this gives -49.5 and -9.7.
contact::Scale scale_of(const Material& material, const thesis::Condition& condition);

}  // namespace strobe::report
