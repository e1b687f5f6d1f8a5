// Where the pulse is deepest. Pure; thread-safe, real-time safe.
#pragma once

#include "common/contact/integration/spin_pulse.hpp"

namespace strobe::contact {

/// Time fraction at which y is lowest: exact form, where vy = 0; simplified form, where its y (which is not
/// the integral of its vy) is lowest, the instant of its largest force.
double deepest_fraction(const SpinPulse& pulse);

}  // namespace strobe::contact
