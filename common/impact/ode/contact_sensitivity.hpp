// How a contact's lift-off changes with its coefficients and the ball's alpha: the derivatives of the
// tangential speed and the spin that lift_off() (contact_ode.hpp) gives, in one pass. For fits; what an
// observation's own uncertainty does is had by moving its inputs.
//
// Between two events the variational equations of the contact are linear and have the closed forms of the
// contact itself, with the derivative of the couple's impulse as the only unknown: one linear system of as
// many equations as the segment has nodes, solved for all inputs at once (variational_equations.hpp). Grip
// and slip follow each other with equal friction, and a footprint stops growing at its largest, so that an
// event's instant does not count to first order: the lift-off is continuously differentiable across changes
// of regime and grazing grips. What changes there at once is the second derivative: near such a boundary the
// derivatives hold over a smaller range.
//
// At the ends of the coefficients' ranges (mu = 0, damping_ratio = 0) the derivative is that from within.
// With mu = 0 and a contact point without slip any friction would hold it, either way: the two sides differ.
// So they do with an offset constantly ahead (OffsetLaw) at vx = 0.
//
// By collocation the derivatives have errors of the tolerance's order times their scale, as the lift-off has.
// Where the integrator had to take over, the method says so, and they are differences of its results, good to
// some 1e-6.
//
// No allocation; thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

/// A contact's coefficients without its restitution, and the ball's alpha.
enum class ContactInput : std::size_t {
  dwell_s,  ///< the coefficient, which is the dwell time without gravity
  mu,
  stiffness_ratio,
  damping_ratio,
  offset_share,
  offset_reference_mps,
  alpha,
};
inline constexpr std::size_t kContactInputs = 7;

struct ContactSensitivity {
  ContactMethod method = ContactMethod::collocation;  ///< that computed it
  /// Of vx and omega at lift-off by each ContactInput, in m/s and rad/s over the input's unit. By
  /// offset_share NaN where that is 0: the nodes of a contact without an offset do not resolve the couple
  /// that a first bit of one would have.
  std::array<double, kContactInputs> vx_mps{};
  std::array<double, kContactInputs> omega_radps{};
};

/// Errors as for lift_off(). `options`: collocation; with dormand_prince the derivatives are differences.
tl::expected<ContactSensitivity, InputError> lift_off_sensitivity(const ball::Ball& ball,
                                                                  const Motion& touchdown,
                                                                  const ContactCoefficients& coefficients,
                                                                  const ContactOptions& options = {});

}  // namespace strobe::impact
