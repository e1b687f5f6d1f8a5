// The normal spring and dashpot behind a scene's e and dwell time, and back. A scene's dwell time is that
// from touchdown to lift-off, the centre back at one radius; the spring lets go before, compressed by
// 2·zeta·v/sqrt(k/m) at the speed v, which the ball then passes freely (contact_path.hpp). Hence
// dwell = (phase of release + 2·zeta)·sqrt(m/k). Pure: thread-safe, no allocation.
#pragma once

#include "common/impact/ode/normal_spring.hpp"

namespace strobe::sim {

struct SpringRebound {
  double e = 0.0;
  double dwell_s = 0.0;  ///< touchdown to lift-off
};

/// mass_kg > 0, stiffness_npm > 0, damping_nspm >= 0.
SpringRebound rebound_of_spring(double mass_kg, double stiffness_npm, double damping_nspm);

/// Its inverse. Errors: as impact::normal_spring().
tl::expected<impact::NormalSpring, impact::InputError> spring_of_rebound(double mass_kg,
                                                                         const SpringRebound& rebound);

}  // namespace strobe::sim
