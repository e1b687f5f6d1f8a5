// The damped sine pulse: the ball's motion while it touches the surface, under a normal force
// F_y = F_max·exp(-f·theta)·sin(theta), theta = pi·t/dwell, F_max = m·|vy_TD|·pi/dwell, and F_x = -ratio·F_y.
// `simplified` is the thesis's integration (f = -ln(e)/pi; velocities short of the true integral by 4.5 % at
// f = 0.046 and 12 % at 0.128); `exact` integrates the force and takes f from e = (1 + exp(-f·pi))/(1 + f²)
// - 1. Origin: the point under the centre at touchdown. Units: s, m, m/s, N. Values agree with 50-digit
// arithmetic to 1e-13 (velocities: relative to the touchdown's speeds, as they pass through zero). Pure, no
// allocation: thread-safe, real-time safe.
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

/// How far the formulas are continued beyond the contact: measured times reach 1.005.
inline constexpr double kEarliestFraction = -0.5;
inline constexpr double kLatestFraction = 1.5;

struct PulseState {
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double x_m = 0.0;  ///< distance travelled since touchdown
  double y_m = 0.0;  ///< top of the ball (and its centre) less its height at touchdown: <= 0
  double fx_n = 0.0;
  double fy_n = 0.0;              ///< >= 0
  double impulse_fraction = 0.0;  ///< share of the normal impulse that has acted; 1 at lift-off
};

class SinePulse {
 public:
  static tl::expected<SinePulse, InputError> make(PulseForm form, const PulseInput& input);

  /// The state at a share of the dwell time, 0…1; a finite number. Outside of it the formulas are continued
  /// as far as kEarliestFraction and kLatestFraction, though the ball no longer touches the surface; beyond
  /// those the state stays as it is there.
  PulseState at_fraction(double time_fraction) const;
  PulseState at_time(double time_s) const { return at_fraction(time_s / input_.dwell_s); }

  /// Time fraction at which `fraction` (0…1) of the normal impulse has acted, as exact as the fraction
  /// determines it; exact form: unique. The simplified form's impulse overshoots 1 before the end at small
  /// damping; the first such time is given.
  double fraction_at_impulse(double fraction) const;

  double damping() const { return damping_; }
  double max_force_n() const;  ///< F_max, the force's scale (its largest value is less by the damping)
  PulseForm form() const { return form_; }
  const PulseInput& input() const { return input_; }

 private:
  SinePulse(PulseForm form, const PulseInput& input, double damping)
      : form_(form), input_(input), damping_(damping) {}

  PulseForm form_;
  PulseInput input_;
  double damping_;
};

/// A rigid rebound seen through the pulse: the same lift-off as rigid(), besides how it came about.
struct PulseRebound {
  Rebound rebound;
  double damping_f = 0.0;
  double grip_fraction = 1.0;  ///< time fraction at which the contact point stopped; 1 if it slid throughout
  double depth_m = 0.0;        ///< how far the centre went down
  double dwell_distance_m = 0.0;
  double max_force_n = 0.0;  ///< largest normal force
};

/// Friction mu·F_y against the slip until the contact point stops, rolling (no friction) from then on.
/// Errors as for rigid() and SinePulse::make().
tl::expected<PulseRebound, InputError> pulse_rebound(PulseForm form, const ball::Ball& ball,
                                                     const Motion& touchdown, double e, double mu,
                                                     double dwell_s);

}  // namespace strobe::impact
