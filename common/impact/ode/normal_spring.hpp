// The Kelvin–Voigt spring and dashpot under a bouncing ball, N = k·y + c·dy/dt: closed forms between its
// constants and the measured restitution and dwell time. The surface can only push, so the ball leaves where
// N = 0, with the spring still compressed, and not where y = 0. In units of the undamped oscillation (tau =
// t·sqrt(k/m), zeta = c/(2·sqrt(k·m))):
//   zeta < 1:  tau_release = 2·acos(zeta)/sqrt(1 - zeta²),   e = exp(-zeta·tau_release)
//   zeta > 1:  tau_release = 2·acosh(zeta)/sqrt(zeta² - 1),  the same e
// the first of which is e = exp(-(zeta/q)(pi - atan2(2·zeta·q, 1 - 2·zeta²))), q = sqrt(1 - zeta²). The two
// meet at zeta = 1, tau = 2, e = exp(-2) = 0.135; with zeta² = cos²(sqrt z) they are one analytic function of
// z = acos(zeta)², by which the inverse is found without loss of digits. Pure, no allocation: thread-safe,
// real-time safe.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// Least restitution for which a spring is computed; its damping ratio is 15.9.
inline constexpr double kMinSpringRestitution = 1e-3;

/// Restitution of the damping ratio zeta >= 0; 1 at zeta = 0.
double restitution_of_damping_ratio(double zeta);

/// Time from touchdown to release times sqrt(k/m): pi at zeta = 0, 2 at zeta = 1.
double release_phase(double zeta);

/// Inverse of restitution_of_damping_ratio. Valid: kMinSpringRestitution <= e <= 1 (below it, down to 0:
/// spring_out_of_range).
tl::expected<double, InputError> damping_ratio_from_restitution(double e);

struct NormalSpring {
  double stiffness_npm = 0.0;    ///< k
  double damping_nspm = 0.0;     ///< c, N·s/m
  double damping_ratio = 0.0;    ///< zeta
  double frequency_radps = 0.0;  ///< sqrt(k/m)
  double release_phase = 0.0;    ///< of the damping ratio
};

/// The spring that gives a ball of `mass_kg` the restitution e and the dwell time, without gravity. Valid: e
/// as above, mass and dwell time positive and within 1e-30…1e30.
tl::expected<NormalSpring, InputError> normal_spring(double mass_kg, double e, double dwell_s);

}  // namespace strobe::impact
