// The damped sine pulse, and the integrals of exp(-f·theta)·sin(theta) over 0…theta: the velocity and the
// position of a ball in contact. Their textbook forms lose digits by cancellation of order theta² and theta³
// at the start of the contact; here they are sums of terms of one sign, accurate to 1e-13 relative over the
// whole range (tests compare with 50 digits). Pure functions, no allocation: thread-safe, real-time safe.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// An angle of the pulse with its functions, which a caller may know more accurately than theta alone gives
/// (near lift-off, where pi - theta is small).
struct PulsePhase {
  double theta_rad = 0.0;
  double decay = 1.0;  ///< exp(-f·theta)
  double sine = 0.0;
  double cosine = 1.0;
  double half_sine = 0.0;  ///< sin(theta/2)

  static PulsePhase at_angle(double damping_f, double theta_rad);
  /// theta = pi·time_fraction; the sine keeps its relative accuracy up to fraction 1, where it is 0.
  static PulsePhase at_fraction(double damping_f, double time_fraction);
};

/// I1 = integral of exp(-f·phi)·sin(phi): impulse over m·|vy_TD|.
///    = [1 - exp(-f·theta)(f·sin + cos)]/(1 + f²)
double impulse_integral(double damping_f, const PulsePhase& phase);

/// I2 = integral of I1: displacement lost to friction, over its ratio and |vy_TD|·dwell/pi.
///    = theta/(1 + f²) - {exp(-f·theta)[(1 - f²)·sin - 2f·cos] + 2f}/(1 + f²)²
double displacement_integral(double damping_f, const PulsePhase& phase);

/// theta - I2: depth of the centre over |vy_TD|·dwell/pi.
double depth_integral(double damping_f, const PulsePhase& phase);

/// The simplified pulse's counterparts: 1 - exp(-f·theta)·cos(theta) and theta - exp(-f·theta)·sin(theta).
double simplified_impulse(double damping_f, const PulsePhase& phase);
double simplified_displacement(double damping_f, const PulsePhase& phase);

// The damped sine pulse: the ball's motion in contact under a normal force
//   F_y = F_max·exp(-f·theta)·sin(theta),  F_x = -ratio·F_y,
//   theta = pi·t/dwell,  F_max = m·|vy_TD|·pi/dwell.
// `simplified` is the thesis's integration (f = -ln(e)/pi; its velocities differ from the true integral by up
// to 4.5 % of |vy_TD| at f = 0.046 and 12 % at 0.128); `exact` integrates the force, with f from e = (1 +
// exp(-f·pi))/(1 + f²) - 1. Origin: the point under the centre at touchdown. Units: s, m, m/s, N. Values
// agree with 50-digit arithmetic to 1e-13 (velocities: of the touchdown's speeds, as they pass through zero).
// Pure, no allocation: thread-safe, real-time safe.

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
