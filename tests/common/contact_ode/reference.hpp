// The contact of common/impact/ode/contact_ode.hpp in 34 digits, or in 50 for differences of contacts, written anew:
// in SI units with the motion itself as the state, steps of Boost.odeint's Fehlberg 7(8) on a mesh that is dense at
// touchdown and release (where the footprint's radius has its root), modes located by bisection.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <optional>

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::testing {

using Quad = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_quad::backend_type,
                                           boost::multiprecision::et_off>;

using Fifty = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_50::backend_type,
                                            boost::multiprecision::et_off>;

/// What a contact depends on, but for the ball's mass, which has no effect; SI units.
template <typename Number>
struct ReferenceInput {
  Number vx_mps, vy_mps, omega_radps;
  Number e, dwell_s, mu, stiffness_ratio, damping_ratio, offset_share, offset_reference_mps;
  Number gravity_mps2, gravity_along_mps2;
  Number diameter_m, alpha;

  ReferenceInput(const ball::Ball& ball, const impact::Motion& touchdown,
                 const impact::ContactCoefficients& coefficients);
};

template <typename Number>
struct ReferenceRelease {
  Number vx_mps;
  Number vy_mps;
  Number omega_radps;
  Number dwell_s;
  Number x_m;
  Number angle_rad;
  std::optional<Number> first_grip_s;  ///< end of the first slip
  int switches = 0;
};
using ReferenceContact = ReferenceRelease<Quad>;

/// With `intervals` steps from touchdown to release; the offset against the spin.
template <typename Number>
ReferenceRelease<Number> reference_release(const ReferenceInput<Number>& input, int intervals);

ReferenceContact reference_contact(const ball::Ball& ball, const impact::Motion& touchdown,
                                   const impact::ContactCoefficients& coefficients, int intervals);

/// Damping ratio of a restitution and, from it, the release's phase, by their textbook forms; zeta < 1.
Quad reference_damping_ratio(const Quad& e);
Quad reference_release_phase(const Quad& zeta);

}  // namespace strobe::testing
