// The contact ODE: normal spring and dashpot, Coulomb friction, a tangential spring and dashpot at the
// contact point that grip and slip, and a normal force that acts ahead of the centre.
//
// With y the depth of the centre below its height at touchdown, u the stretch of the tangential spring, s =
// vx + R·omega, a(y) = sqrt(y(2R - y)) the footprint's radius (R beyond y = R):
//   N  = k·y + c·dy/dt (only pushes; the ball leaves where N = 0),        m·d²y/dt² = -N + m·g,
//   F  = k_t·u + c_t·du/dt,  |F| <= mu·N,                                m·dvx/dt = -F + m·g_x,
//   alpha·m·R²·domega/dt = -R·F + d·N,
//   grips: du/dt = s;   slips in direction sigma = ±1: F = sigma·mu·N, with sigma·(s - du/dt) > 0.
//
// The offset d. Pressure under a rotating footprint: the point at xi ahead of the centre moves down at -vy -
// omega·xi, so that with damping the pressure is higher where the rotation presses down, and its centre is
// displaced by an amount odd in omega, ahead of the centre when the ball rolls forward (omega < 0). Hence
//   d = -delta·a(y)·w/sqrt(w² + w0²),   w = R·omega,
// odd in the spin, 0 without spin and without footprint. Its couple has the power d·N·omega <= 0 at every
// instant. With
//   E = m(vx² + vy² + alpha·R²·omega²)/2 + k·y²/2 + k_t·u²/2 - m·g·y - m·g_x·x:
//   dE/dt = -c(dy/dt)² - F(s - du/dt) - c_t(du/dt)² + d·N·omega,
// each term <= 0 (F and s - du/dt have the same sign), so energy never grows. g and g_x are the weight's
// parts towards the surface and along it, 0 by default. A mirrored contact (vx, omega and g_x reversed) is
// the mirror image to the last bit.
//
// Numerics, in units of |vy|, sqrt(m/k) and m, as changes since touchdown, so that no range of speeds loses
// digits.
//
// dormand_prince, the reference and what takes over where collocation gives up: the embedded pair 5(4) with
// the error of speeds, displacements and energies within the tolerance. Mode changes and the release are
// bracketed on the step's cubic Hermite interpolant and then located to rounding by repeating the step with
// that size, so that no step spans a change of mode and the method keeps its order; likewise friction
// reversals, the deepest point and the largest force. Where rounding decides between grip and slip, the
// present mode is kept for 1e-7 of sqrt(m/k).
//
// collocation, the main method: the normal motion is a damped sine in closed form, and with it, gripping or
// slipping, all tangential motion but the impulse of the offset's couple, which is a fixed point on
// Gauss–Legendre nodes (segment_solver.hpp). Segments end where friction changes its law; their error is that
// of the last Legendre coefficients. Where that would take too many (grips that decay within a small part of
// the contact, w0 far below |vy|) or the closed forms do not hold (a weight of a tenth and more of the
// largest force, dashpots whose stretch decays as the normal force does) the result is dormand_prince's to
// 1e-12, and says so: its steps may miss how sharply an offset turns round. The energies' sums are good to
// the tolerance, but not better than 5e-8 of m·|vy| times the speeds that change (1e-5 with tolerances above
// 3e-8); max_friction_n to the tolerance's root.
//
// No allocation in simulate() and lift_off(); thread-safe, real-time safe.
// Sources: R. Cross, Grip-slip behavior of a bouncing ball, 2002 (tangential spring, grip and slip); E.
// Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.5 to II.7.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// Speed R·|omega| at which the offset is 1/sqrt(2) of the full one. Of 2.5 to 50 m/s the value that
/// fits the thesis best (chi-square 42.2; 45.0 at 2.5, 48.1 at 50): the data constrain it weakly.
inline constexpr double kContactOffsetReference_mps = 6.0;

/// alpha of the fit in ContactCoefficients.
inline constexpr double kContactAlpha = 0.579;

/// How the normal force is offset from the centre.
enum class OffsetLaw {
  against_spin,  ///< the law above: never adds energy
  /// d = delta·a(y) ahead, in the direction of vx at touchdown, throughout. For comparison with published
  /// fits only: it adds energy where the ball spins backward, and is not 0 without spin.
  constant_ahead,
};

/// Coefficients of a pair of ball and surface; the defaults are fitted to the thesis's 21 conditions
/// (contact_fit.hpp: rms .397 m/s and 11.0 rad/s, where single shots have sds of .38 and 11.5). k and c
/// follow from e and the dwell time (normal_spring.hpp), the tangential ones are relative to k.
struct ContactCoefficients {
  double e = 0.75;                 ///< normal restitution, 1e-3…1
  double dwell_s = 5e-3;           ///< touchdown to release, 1e-9…1e3
  double mu = 0.537;               ///< coefficient of friction, 0…1e3
  double stiffness_ratio = 1.406;  ///< k_t/k, 1e-3…1e3
  double damping_ratio = 0.687;    ///< c_t/sqrt(k_t·m), 0 (none) or 0.01…10
  double offset_share = 0.149;     ///< delta: offset over the footprint's radius at full speed, 0…1
  double offset_reference_mps = kContactOffsetReference_mps;  ///< w0, 1e-9…1e9
  OffsetLaw offset_law = OffsetLaw::against_spin;
  double gravity_mps2 = 0.0;  ///< towards the surface, 0…1e3; at most 0.7 % of mu in the thesis's shots
  double gravity_along_mps2 = 0.0;  ///< along the surface, +x, -1e3…1e3: 0 on a level plate
};

enum class ContactMode { slips_forward, slips_backward, grips };

constexpr std::string_view name(ContactMode mode) {
  constexpr std::array<std::string_view, 3> names{"slips_forward", "slips_backward", "grips"};
  return names[static_cast<std::size_t>(mode)];
}

enum class ContactEventKind { grip, slip, friction_reversal, deepest, largest_force, release };

constexpr std::string_view name(ContactEventKind kind) {
  constexpr std::array<std::string_view, 6> names{"grip",    "slip",          "friction_reversal",
                                                  "deepest", "largest_force", "release"};
  return names[static_cast<std::size_t>(kind)];
}

struct ContactEvent {
  double time_s = 0.0;
  ContactEventKind kind = ContactEventKind::release;
};

inline constexpr int kMaxContactEvents = 64;

/// In joules. dissipated_j() equals kinetic_td_j - kinetic_lo_j within the tolerance.
struct ContactEnergy {
  double kinetic_td_j = 0.0;  ///< of translation and rotation
  double kinetic_lo_j = 0.0;
  double kinetic_lost_j = 0.0;  ///< their difference, computed without cancellation
  double normal_damping_j = 0.0;
  double sliding_j = 0.0;
  double tangential_damping_j = 0.0;
  double offset_j = 0.0;              ///< taken from the spin by the offset normal force
  double normal_spring_left_j = 0.0;  ///< in the compressed spring at release: lost, as the ball has left
  double tangential_spring_left_j = 0.0;
  double gravity_work_j = 0.0;  ///< done by both parts of the weight from touchdown to release
  double dissipated_j() const {
    return normal_damping_j + sliding_j + tangential_damping_j + offset_j + normal_spring_left_j +
           tangential_spring_left_j - gravity_work_j;
  }
};

/// Of the same laws. What was asked for and what a summary names differ where collocation gives up.
enum class ContactMethod { collocation, dormand_prince };

constexpr std::string_view name(ContactMethod method) {
  constexpr std::array<std::string_view, 2> names{"collocation", "dormand_prince"};
  return names[static_cast<std::size_t>(method)];
}

/// What a contact leaves behind it.
struct ContactLiftOff {
  Motion lift_off;
  /// grips: the contact point stuck, or came to a stop as a rigid one (s = 0), before release.
  Regime regime = Regime::slides;
  double dwell_s = 0.0;  ///< touchdown to release
  /// Skidding ends: the first grip after slipping; 0 where the ball grips from touchdown on; nullopt where it
  /// never sticks (the tangential spring may hold briefly as the force sets in: that is no grip).
  std::optional<double> skid_to_grip_s;
  double dwell_distance_m = 0.0;                      ///< of the centre along the surface
  double rotation_rad = 0.0;                          ///< touchdown to release, counter-clockwise
  ContactMethod method = ContactMethod::collocation;  ///< that computed it, not always the one asked for
};

/// With the times and sums on the way.
struct ContactSummary : ContactLiftOff {
  /// The ball's rigid contact point stops, s = vx + R·omega = 0, as seen from the velocities alone; the
  /// tangential spring's stretch separates it from skid_to_grip_s. nullopt if it does not stop.
  std::optional<double> slip_zero_s;
  int friction_reversals = 0;
  double max_depth_m = 0.0;
  double max_depth_time_s = 0.0;
  double max_force_n = 0.0;  ///< largest N; at touchdown where the dashpot dominates
  double max_force_time_s = 0.0;
  double max_friction_n = 0.0;  ///< largest |F| at the ends of steps and events
  double slip_lo_mps = 0.0;     ///< vx + R·omega at release
  double impulse_ratio = 0.0;   ///< (vx_TD - vx_LO)/(vy_LO - vy_TD)
  double mean_offset_m = 0.0;   ///< impulse-weighted offset of the normal force, along +x
  ContactEnergy energy;
  std::array<ContactEvent, kMaxContactEvents> events{};
  int event_count = 0;
  int events_left_out = 0;  ///< grips, slips and reversals that the list has no room for
  int steps = 0;            ///< collocation: segments
  int evaluations = 0;      ///< of the right-hand side, those of locating events included

  std::span<const ContactEvent> event_list() const {
    return {events.data(), static_cast<std::size_t>(event_count)};
  }
};

struct ContactOptions {
  ContactMethod method = ContactMethod::collocation;
  /// Error at release relative to the scale of each motion, 1e-12…1e-3. Of 80,000 drawn contacts 14 had
  /// more: by collocation 2, up to 2.7 times that, by the integrator 12, up to 8 times; of
  /// 120,000 others none had more than 12 times it.
  double tolerance = 1e-9;
};

/// One contact, without its trajectory. Errors: not_finite, ball_out_of_range, not_approaching,
/// restitution_out_of_range, friction_negative, spring_out_of_range, offset_out_of_range, dwell_not_positive,
/// tolerance_out_of_range; magnitude_out_of_range (|vx|, |vy| above 1e9 m/s, |vy| below 1e-15 m/s, |omega|
/// above 1e9 rad/s, |R·omega| or |vx| above 1e15·|vy|, diameter or mass outside 1e-9…1e9, alpha below 1e-6,
/// mu, dwell time or gravity beyond the ranges above); no_release (gravity); too_many_steps (a million
/// adaptive ones). All of the range is computed where alpha is 0.01 or more and the reference speed
/// |vy|/10,000 or more; below that a grip may be too stiff, or the offset act like dry friction. Most of the
/// others are computed too.
tl::expected<ContactSummary, InputError> simulate(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options = {});

/// The same contact; by collocation at a small part of simulate()'s cost. Errors as for simulate().
tl::expected<ContactLiftOff, InputError> lift_off(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options = {});

}  // namespace strobe::impact
