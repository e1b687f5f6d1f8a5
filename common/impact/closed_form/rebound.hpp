// Rebound models that have a formula, and what may be wrong with their inputs: an enumeration, so that the
// models allocate nothing.
#pragma once

#include <array>
#include <string_view>
#include <tl/expected.hpp>

#include "common/ball/ball.hpp"
#include "common/ball/regime.hpp"

namespace strobe::impact {

enum class InputError {
  not_finite,                ///< NaN or infinity among the inputs
  not_approaching,           ///< vy at touchdown is not negative: the ball does not move towards the surface
  restitution_out_of_range,  ///< e outside 0…1
  friction_negative,         ///< mu below 0
  tangential_restitution_out_of_range,  ///< e_x outside -1…1 (outside of it a grip would feed energy)
  offset_out_of_range,     ///< offset below 0, not below the radius, or its reference speed not positive
  ball_out_of_range,       ///< diameter, mass or alpha outside ball::check
  dwell_not_positive,      ///< dwell time of 0 or less
  damping_undefined,       ///< e = 0 in the simplified pulse, whose damping would be infinite
  magnitude_out_of_range,  ///< a finite number, but too large or too small for the model's arithmetic
  spring_out_of_range,     ///< a contact spring's or dashpot's ratio outside the range its model states
  tolerance_out_of_range,  ///< a tolerance outside 1e-12…1e-3
  no_release,              ///< the ball does not leave the surface: its weight holds it there
  too_many_steps,  ///< more steps than an integration allows: alpha or the reference speed is too small
};

/// Largest and smallest magnitude of the closed forms' inputs, within which none of their products or
/// quotients overflows; beyond it magnitude_out_of_range. The smallest applies to divisors (vy, diameter,
/// mass, alpha, dwell time, reference speed); all other inputs may be smaller, or 0.
inline constexpr double kMaxMagnitude = 1e30;
inline constexpr double kMinMagnitude = 1e-30;

/// Both are true of NaN.
constexpr bool too_large(double value) { return !(value <= kMaxMagnitude && value >= -kMaxMagnitude); }
constexpr bool too_small(double value) { return !(value >= kMinMagnitude); }

constexpr std::string_view message(InputError error) {
  constexpr std::array<std::string_view, 14> words{
      "inputs must be finite numbers",
      "vy must be negative: the ball must move towards the surface",
      "e must be from 0 to 1",
      "mu must not be negative",
      "ex must be from -1 to 1",
      "offset must be at least 0 and less than the radius",
      "diameter and mass must be positive, alpha in (0, 2/3]",
      "dwell time must be positive",
      "the simplified pulse needs e above 0",
      "a speed, a length, a mass or a time is too large or too small to compute with",
      "e is below 0.001, kt over k not from 0.001 to 1000, or ct neither 0 nor from 0.01 to 10",
      "tolerance is out of its range",
      "the ball does not leave the surface: its weight holds it there",
      "the contact takes too many steps: alpha is below 0.01 or the offset's reference speed below "
      "|vy|/10000",
  };
  static_assert(words.size() == static_cast<std::size_t>(InputError::too_many_steps) + 1);
  return words[static_cast<std::size_t>(error)];
}

// Rebound models: from the velocities at touchdown and a few coefficients to those at lift-off. The surface
// is along x, the ball comes from above (vy < 0); spin is counter-clockwise positive (backspin for a ball
// moving along +x). Slip of the contact point: s = vx + R·omega. J = (1 + e)|vy| is the normal impulse per
// mass; the ball's weight is neglected (0.1–0.7 % of mu). Values agree with 50-digit arithmetic to 1e-13
// relative or, where they pass through zero, to 1e-13 of the terms whose difference they are (the slip at
// lift-off: of the slip and its changes, not of the speeds). Inputs beyond kMaxMagnitude are refused. Pure
// functions, no allocation: thread-safe, real-time safe. Over a million a second on one core.
// Sources: H. Brody, That's how the ball bounces, 1984 (thesis eq. 9–16); R. Cross, Grip-slip behavior of a
// bouncing ball, 2002.

struct Motion {
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
};

/// Rolling speed at which the normal force's offset is 1/sqrt(2) of the full one (fitted, see
/// kFittedToThesis).
inline constexpr double kOffsetReferenceSpeed_mps = 2.5;

/// Coefficients of a pair of ball and surface.
struct Coefficients {
  double e = 0.0;         ///< normal restitution, 0…1
  double mu = 0.0;        ///< coefficient of friction, >= 0
  double e_x = 0.0;       ///< tangential restitution of a grip, -1…1; 0: the ball rolls off
  double offset_m = 0.0;  ///< normal force ahead of the centre at full rolling speed, 0…R
  double offset_reference_mps = kOffsetReferenceSpeed_mps;  ///< > 0
};

/// Fitted to the thesis's Tables 5–7 (21 conditions), with ball::kMeasuredAlpha: rms .42 m/s and 14.3 rad/s
/// against .495 and 15.4 of the best constant offset (mu .567, e_x .089, 2.5 mm). `e` is the caller's.
inline constexpr Coefficients kFittedToThesis{.e = 0.75, .mu = 0.570, .e_x = 0.087, .offset_m = 0.0030};

struct Rebound {
  Motion lift_off;
  /// Whether friction was at its limit throughout. The velocities may tell otherwise: see regime_of().
  Regime regime = Regime::slides;
  double slip_lo_mps = 0.0;    ///< vx + R·omega at lift-off
  double impulse_ratio = 0.0;  ///< (vx_TD - vx_LO)/J: mu if it slides, less if it grips; 0 for e.g. mu = 0
  double offset_m = 0.0;       ///< offset of the normal force that acted, along +x
};

/// The regime that a measurement of this rebound tells, by regime_of_exact(): `grips` too where friction at
/// its limit changed vx by all that rolling takes, which may be less than what a grip with tangential
/// restitution takes.
Regime regime_of(const ball::Ball& ball, const Motion& touchdown, const Rebound& rebound);

/// Rigid body: slides throughout (thesis eq. 9–12) unless friction suffices to make it roll (eq. 14, 15 for
/// any alpha). It slides throughout iff mu·J < |s|·alpha/(1 + alpha): the thesis's table after (16a),
/// corrected for signed slip. Friction acts against the slip: a ball with topspin faster than rolling is
/// driven forward. Errors: not_finite, ball_out_of_range, not_approaching, restitution_out_of_range,
/// friction_negative, magnitude_out_of_range.
tl::expected<Rebound, InputError> rigid(const ball::Ball& ball, const Motion& touchdown, double e, double mu);

/// Rigid body with tangential restitution e_x of a grip and a normal force ahead of the centre (footprint
/// asymmetry, the thesis's rolling friction):
///   alpha·R²·Δomega = R·Δvx + d·J,   gripping: s_LO = -e_x·s_TD, if that needs no more than mu·J of
///   friction.
/// The friction impulse is clamped to ±mu·J in the direction that gripping requires. The offset is d =
/// offset_m·u/sqrt(u² + u0²), with u = (vx - R·omega)/2 the speed at which the contact point rolls over the
/// surface and u0 = offset_reference_mps: odd in the direction of rolling, 0 where nothing rolls. It is
/// reduced, continuously, where it would add to the tangential energy vx² + alpha·R²·omega². With offset_m =
/// 0 and e_x = 0 this is rigid(). Errors: those of rigid(), tangential_restitution_out_of_range,
/// offset_out_of_range.
tl::expected<Rebound, InputError> grip(const ball::Ball& ball, const Motion& touchdown,
                                       const Coefficients& coefficients);

}  // namespace strobe::impact
