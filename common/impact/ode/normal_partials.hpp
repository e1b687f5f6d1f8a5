// Derivatives of the normal motion (normal_motion.hpp) with respect to zeta and to gravity, at a fixed time, in
// contact_system.hpp's units. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/normal_motion.hpp"

namespace strobe::impact::detail {

/// One of the two derivatives of what NormalMotion gives at a time.
struct NormalPartial {
  double depth = 0.0, rate = 0.0, force = 0.0, force_rate = 0.0;
  double impulse = 0.0, impulse_integral = 0.0;
};

struct NormalPartials {
  NormalPartial zeta, gravity;
};

NormalPartials normal_partials(const System& system, const NormalState& at);

}  // namespace strobe::impact::detail
