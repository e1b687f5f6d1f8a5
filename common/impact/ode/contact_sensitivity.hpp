// How a contact's lift-off changes with its touchdown, its coefficients and the ball: the derivatives of the numbers that
// lift_off() (contact_ode.hpp) gives, in one pass.
//
// Between two events the variational equations of the contact are linear and have the closed forms of the contact itself,
// with the derivative of the couple's impulse as the only unknown: one linear system of as many equations as the segment
// has nodes, solved for all inputs at once (segment_partials.hpp). Grip and slip follow each other with equal friction, and
// a footprint stops growing at its largest, so that an event's instant does not count to first order: the lift-off is
// continuously differentiable across changes of regime and grazing grips. What changes there at once is the second
// derivative: near such a boundary the derivatives hold over a smaller range.
//
// Where the derivative from either side differs, `kink` says why. At the ends of the inputs' ranges (e = 1, mu = 0,
// damping_ratio = 0, offset_share = 0) the derivative is that from within.
//
// By collocation the derivatives have errors of the tolerance's order times their scale, as the lift-off has. Where the
// integrator had to take over, the method says so, and they are differences of its results, good to some 1e-6.
//
// No allocation; thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

/// What the lift-off depends on. The ball's mass is not among them: stiffnesses are relative to it.
enum class ContactInput : std::size_t {
  vx_mps,
  vy_mps,
  omega_radps,
  e,
  dwell_s,  ///< the coefficient, which is the dwell time without gravity
  mu,
  stiffness_ratio,
  damping_ratio,
  offset_share,
  offset_reference_mps,
  gravity_mps2,
  gravity_along_mps2,
  diameter_m,
  alpha,
};
inline constexpr std::size_t kContactInputs = 14;

constexpr std::string_view name(ContactInput input) {
  constexpr std::array<std::string_view, kContactInputs> names{"vx_mps",          "vy_mps",
                                                               "omega_radps",     "e",
                                                               "dwell_s",         "mu",
                                                               "stiffness_ratio", "damping_ratio",
                                                               "offset_share",    "offset_reference_mps",
                                                               "gravity_mps2",    "gravity_along_mps2",
                                                               "diameter_m",      "alpha"};
  return names[static_cast<std::size_t>(input)];
}

enum class ContactOutput : std::size_t {
  vx_mps,
  vy_mps,
  omega_radps,
  dwell_s,
  dwell_distance_m,
  rotation_rad,
};
inline constexpr std::size_t kContactOutputs = 6;

constexpr std::string_view name(ContactOutput output) {
  constexpr std::array<std::string_view, kContactOutputs> names{
      "vx_mps", "vy_mps", "omega_radps", "dwell_s", "dwell_distance_m", "rotation_rad"};
  return names[static_cast<std::size_t>(output)];
}

/// Why the derivatives from either side differ.
enum class ContactKink {
  none,
  frictionless_rest,  ///< mu = 0 and a contact point without slip: any friction would hold it
  offset_turns_round  ///< a constant offset, which is ahead of the centre, and vx = 0
};

struct ContactSensitivity {
  ContactLiftOff contact;
  /// derivative[output][input], in the output's unit over the input's.
  std::array<std::array<double, kContactInputs>, kContactOutputs> derivative{};
  ContactKink kink = ContactKink::none;

  double of(ContactOutput output, ContactInput input) const {
    return derivative[static_cast<std::size_t>(output)][static_cast<std::size_t>(input)];
  }
};

/// Errors as for lift_off(). `options`: collocation; with another method the derivatives are differences.
tl::expected<ContactSensitivity, InputError> lift_off_with_sensitivity(
    const ball::Ball& ball, const Motion& touchdown, const ContactCoefficients& coefficients,
    const ContactOptions& options = {.method = ContactMethod::collocation});

}  // namespace strobe::impact
