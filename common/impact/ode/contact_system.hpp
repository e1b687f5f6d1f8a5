// Implementation of contact_ode.hpp, which states the mechanics: the dimensionless equations, and one step of
// dormand_prince. Speeds in |vy_TD|, times in sqrt(m/k), masses in m; tangential motion as changes since
// touchdown. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <array>
#include <cmath>

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact::detail {

enum Component : std::size_t {
  kDepth,
  kDepthRate,
  kVxChange,
  kSpinChange,  ///< of w = R·omega
  kStretch,
  kPathChange,   ///< integral of kVxChange
  kAngleChange,  ///< integral of kSpinChange
  kDampingLoss,
  kSlidingLoss,
  kTangentialLoss,
  kOffsetLoss,
  kOffsetImpulse,  ///< integral of d·N/R
  kComponents
};

using State = std::array<double, kComponents>;

/// The dimensionless coefficients of one contact.
struct System {
  double zeta = 0.0;
  double release_phase = 0.0;  ///< time of release without gravity
  double mu = 0.0;
  double kt = 0.0;  ///< k_t/k
  double ct = 0.0;  ///< c_t/sqrt(k·m)
  double alpha = 0.0;
  double delta = 0.0;
  double ahead = 0.0;  ///< sign of a constant offset; 0: against the spin
  double w_ref = 0.0;
  double radius = 0.0;
  double gravity = 0.0;
  double along = 0.0;  ///< gravity along +x
  double vx0 = 0.0;
  double w0 = 0.0;
  double slip0 = 0.0;

  double speed_mps = 1.0;        ///< unit of speed
  double frequency_radps = 1.0;  ///< 1/unit of time
  double mass_kg = 1.0;
  double radius_m = 1.0;

  /// Of the offset at w = R·omega, from -1 to 1.
  double offset_direction(double spin) const {
    return ahead != 0.0 ? ahead : -spin / std::sqrt(spin * spin + w_ref * w_ref);
  }
  double normal_force(const State& z) const { return z[kDepth] + 2.0 * zeta * z[kDepthRate]; }
  double normal_force_rate(const State& z) const {
    return z[kDepthRate] + 2.0 * zeta * (gravity - normal_force(z));
  }
  double slip(const State& z) const { return slip0 + (z[kVxChange] + z[kSpinChange]); }
  double spin(const State& z) const { return w0 + z[kSpinChange]; }
  /// Force that the spring and dashpot would need to hold the contact point.
  double holding_force(const State& z) const { return kt * z[kStretch] + ct * slip(z); }
  double friction(const State& z, ContactMode mode) const;
  /// Of the centre along the surface since touchdown.
  double path(double tau, double path_change) const { return vx0 * tau + path_change; }
  /// Scale of the changes that a contact of a few units of time makes to the tangential motion, at least the
  /// least whose inverse is finite: friction's, no more than what stops the slip, the offset's and the
  /// weight's.
  double tangential_scale() const;
  /// d/R of the normal force, along +x.
  double offset(const State& z) const;
};

constexpr double direction(ContactMode mode) {
  return mode == ContactMode::slips_forward ? 1.0 : mode == ContactMode::slips_backward ? -1.0 : 0.0;
}

constexpr ContactMode slipping(double direction) {
  return direction < 0.0 ? ContactMode::slips_backward : ContactMode::slips_forward;
}

tl::expected<System, InputError> make_system(const ball::Ball& ball, const Motion& touchdown,
                                             const ContactCoefficients& coefficients);

/// In SI units, of the state at release: all but regime, end of skidding and method.
ContactLiftOff lift_off_of(const System& system, const State& z, double tau);
/// Likewise, but for what is lost on the way: the kinetic energies, what is left in the springs, the weight's
/// work.
ContactEnergy energy_at_release(const System& system, const State& z, double tau);
/// Puts an event where it belongs in time; grips, slips and reversals that find no room are counted only.
void add_event(ContactSummary& summary, const ContactEvent& event);

State derivative(const System& system, const State& z, ContactMode mode);

ContactMode initial_mode(const System& system);

/// The end of a step of dormand_prince of size h from z with slope k1 = derivative(z).
State take_step(const System& system, ContactMode mode, const State& z, const State& k1, double h);

/// The same with the difference of its two orders.
State take_step_with_error(const System& system, ContactMode mode, const State& z, const State& k1, double h,
                           State& error);

}  // namespace strobe::impact::detail
