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

/// (sine - t·cosine)/omega2 of an Oscillation, whatever sign omega2 has: -2 times the derivative of the sine with respect
/// to omega2. By its series where the difference would lose digits.
inline bool turned_by_series(double omega2, double t) { return std::abs(omega2 * t * t) <= 0.1; }
inline double turned_sine_series(double omega2, double t) {
  // The next term is below 1e-13 of the first.
  const double z = omega2 * t * t;
  return t * t * t *
         (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0 - z * (1.0 / 3991680.0)))));
}
inline double turned_sine(double omega2, double t, const Oscillation& o) {
  return turned_by_series(omega2, t) ? turned_sine_series(omega2, t) : (o.sine - t * o.cosine) / omega2;
}

struct NormalPartials {
  NormalPartial zeta, gravity;
};

NormalPartials normal_partials(const System& system, const NormalState& at);

}  // namespace strobe::impact::detail
