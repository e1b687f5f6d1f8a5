// The damped sine pulse: the ball's motion in contact under a normal force
//   F_y = F_max·exp(-f·theta)·sin(theta),  F_x = -ratio·F_y,
//   theta = pi·t/dwell,  F_max = m·|vy_TD|·pi/dwell.
// `simplified` is the thesis's integration (f = -ln(e)/pi; its velocities differ from the true integral by up
// to 4.5 % of |vy_TD| at f = 0.046 and 12 % at 0.128); `exact` integrates the force, with f from e = (1 +
// exp(-f·pi))/(1 + f²) - 1. Origin: the point under the centre at touchdown. Units: s, m, m/s, N. Values
// agree with 50-digit arithmetic to 1e-13 (velocities: of the touchdown's speeds, as they pass through zero).
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/input_error.hpp"

namespace strobe::impact {

enum class PulseForm { exact, simplified };

constexpr std::string_view name(PulseForm form) { return form == PulseForm::exact ? "exact" : "simplified"; }

/// Damping f that gives the restitution e, to 1e-13. Valid: simplified 0 < e <= 1, exact 0 <= e <= 1 (f at
/// most 0.4745).
tl::expected<double, InputError> damping_from_restitution(PulseForm form, double e);

struct PulseInput {
  double vx_td_mps = 0.0;
  double vy_td_mps = 0.0;  ///< < 0
  double e = 0.0;          ///< see damping_from_restitution
  /// F_x = -ratio·F_y throughout; negative where friction drives the ball forward.
  double impulse_ratio = 0.0;
  double dwell_s = 0.0;                   ///< > 0
  double mass_kg = ball::kThesisMass_kg;  ///< > 0; only the forces depend on it
};

/// Range of time fractions in which the formulas are evaluated: measured times reach 1.005.
inline constexpr double kMinTimeFraction = -0.5;
inline constexpr double kMaxTimeFraction = 1.5;

struct PulseState {
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double x_m = 0.0;  ///< displacement since touchdown
  double y_m = 0.0;  ///< top of the ball (and its centre) less its height at touchdown: <= 0
  double fx_n = 0.0;
  double fy_n = 0.0;              ///< >= 0
  double impulse_fraction = 0.0;  ///< of the normal impulse, up to now; 1 at lift-off
};

class SinePulse {
 public:
  /// Errors: not_finite, not_approaching, dwell_not_positive, ball_out_of_range, magnitude_out_of_range, and
  /// those of damping_from_restitution().
  static tl::expected<SinePulse, InputError> make(PulseForm form, const PulseInput& input);

  /// The state at time_fraction·dwell after touchdown. Valid: finite. Outside of 0…1, where the ball does not
  /// touch the surface, the formulas are continued; the fraction is clamped to
  /// kMinTimeFraction…kMaxTimeFraction.
  PulseState at_fraction(double time_fraction) const;
  PulseState at_time(double time_s) const { return at_fraction(time_s / input_.dwell_s); }

  /// Time fraction at which `fraction` (0…1) of the normal impulse has acted, as accurate as the fraction
  /// determines it. In the exact form it is unique; the simplified form's impulse passes 1 before the end at
  /// small damping, and the first such time is returned.
  double fraction_at_impulse(double fraction) const;

  double damping() const { return damping_; }
  double max_force_n() const;  ///< F_max, the force's scale; its largest value is less by the damping
  PulseForm form() const { return form_; }
  const PulseInput& input() const { return input_; }

 private:
  SinePulse(PulseForm form, const PulseInput& input, double damping)
      : form_(form), input_(input), damping_(damping) {}

  PulseForm form_;
  PulseInput input_;
  double damping_;
};

/// A rigid rebound with the course of its contact by the pulse: the lift-off is that of rigid().
struct PulseRebound {
  Rebound rebound;
  double damping_f = 0.0;
  double grip_fraction = 1.0;  ///< time fraction at which the contact point stops; 1 if it slides throughout
  double depth_m = 0.0;        ///< largest displacement of the centre towards the surface
  double dwell_distance_m = 0.0;
  double max_force_n = 0.0;  ///< largest normal force
};

/// Friction mu·F_y against the slip until the contact point stops, rolling (no friction) from then on.
/// Errors as for rigid() and SinePulse::make().
tl::expected<PulseRebound, InputError> pulse_rebound(PulseForm form, const ball::Ball& ball,
                                                     const Motion& touchdown, double e, double mu,
                                                     double dwell_s);

}  // namespace strobe::impact
