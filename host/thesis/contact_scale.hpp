// Scales that turn a set's fractions into SI units. Pure; thread-safe.
#pragma once

#include "common/contact/differentiation/differentiation.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::report {

/// Dwell time and distance are the condition's. The total rotation is not printed: it is computed by the
/// contact ODE, which was fitted to velocities and spins alone; where the images rotate the other way
/// (back_17, whose total is near zero), it is the one with which they fit the ODE best. The thesis's own
/// totals follow from the corrected entries of its Table 13 for two sets, -51.0 degrees (zero_23) and -9.7
/// (back_22); this gives -49.5 and -9.7.
contact::ContactScale contact_scale(const ThesisInputs& inputs, const thesis::Condition& condition);

}  // namespace strobe::report
