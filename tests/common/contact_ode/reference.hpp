// The contact of common/impact/ode/contact_ode.hpp in 34 digits, written anew: in SI units with the motion
// itself as the state, steps of Boost.odeint's Fehlberg 7(8) on a mesh that is dense at touchdown and release
// (where the footprint's radius has its root), modes located by bisection.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <optional>

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::testing {

using Quad = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_quad::backend_type,
                                           boost::multiprecision::et_off>;

struct ReferenceContact {
  Quad vx_mps;
  Quad vy_mps;
  Quad omega_radps;
  Quad dwell_s;
  Quad x_m;
  Quad angle_rad;
  std::optional<Quad> first_grip_s;  ///< end of the first slip
  int switches = 0;
};

/// With `intervals` steps from touchdown to release. No gravity towards the surface; the offset against the spin.
ReferenceContact reference_contact(const ball::Ball& ball, const impact::Motion& touchdown,
                                   const impact::ContactCoefficients& coefficients, int intervals);

/// Damping ratio of a restitution and, from it, the release's phase, by their textbook forms; zeta < 1.
Quad reference_damping_ratio(const Quad& e);
Quad reference_release_phase(const Quad& zeta);

}  // namespace strobe::testing
