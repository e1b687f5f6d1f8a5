// The damped sine pulse extended to spin. Slip of the contact point s = vx + R·omega. While it slips,
// friction is F_x = -sgn(s)·mu·F_y. Once s = 0 (the root of a closed form) the ball rolls, and friction only
// balances the moment of the normal force: 0 with that force under the centre, else F_x = -d/(R(1 +
// alpha))·F_y (limited to mu·F_y) for a force `offset_m` = d ahead of it (rolling friction).
//
// With alpha·m·R²·domega = R·F_x·dt + d·F_y·dt every quantity is linear in the pulse's two integrals I1 and
// I2 (impact/closed_form/sine_pulse.hpp), so positions and the rotation are closed forms throughout; the
// thesis stopped before the rotation. With d = 0 the lift-off is that of impact::rigid(). The simplified form
// uses the thesis's approximations of I1 and I2, which are not quite each other's derivative.
//
// Axes and signs: x in the direction of travel, omega and rotation counter-clockwise positive. Units: s, m,
// rad, N. Accuracy: 1e-13 of each quantity's natural scale (the sum of its terms' magnitudes). Pure, no
// allocation: thread-safe, real-time safe.
#pragma once

#include <optional>
#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"

namespace strobe::contact {

struct SpinPulseInput {
  ball::Ball ball;
  impact::Motion touchdown;
  double e = 0.0;         ///< see impact::damping_from_restitution
  double mu = 0.0;        ///< coefficient of friction while the contact point slips, >= 0
  double dwell_s = 0.0;   ///< > 0
  double offset_m = 0.0;  ///< of the normal force along +x, magnitude below R; the caller chooses the sign
  impact::PulseForm form = impact::PulseForm::exact;
};

struct SpinPulseState {
  double x_m = 0.0;           ///< displacement since touchdown
  double y_m = 0.0;           ///< height of the centre less that at touchdown: <= 0
  double rotation_rad = 0.0;  ///< since touchdown
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
  double slip_mps = 0.0;  ///< vx + R·omega; exactly 0 once it rolls
  double fx_n = 0.0;
  double fy_n = 0.0;
};

class SpinPulse {
 public:
  /// Errors: those of impact::rigid() and impact::SinePulse::make(); magnitude_out_of_range also for a motion
  /// beyond double precision.
  static tl::expected<SpinPulse, impact::InputError> make(const SpinPulseInput& input);

  /// The state at a share of the dwell time, 0…1. Outside of it the formulas are continued, though the ball
  /// no longer touches the surface.
  SpinPulseState at_fraction(double time_fraction) const;

  /// Time fraction at which the slip becomes zero; nullopt if that does not happen before lift-off.
  std::optional<double> grip_fraction() const { return grip_fraction_; }

  /// grips if the ball rolls from grip_fraction() on.
  Regime regime() const;

  /// Time fraction of the largest normal force: tan(pi·T) = 1/f.
  double largest_force_fraction() const;

  /// Time fraction at which y is lowest: where vy = 0; in the simplified form, whose y is not the integral of
  /// its vy, the instant of the largest force.
  double deepest_fraction() const;

  /// From touchdown to lift-off.
  double total_rotation_rad() const { return at_fraction(1.0).rotation_rad; }

  double damping() const { return unit_.damping(); }
  const SpinPulseInput& input() const { return input_; }

 private:
  SpinPulse(const SpinPulseInput& input, const impact::SinePulse& unit);
  void find_grip();

  SpinPulseInput input_;
  impact::SinePulse unit_;  // from vx = 0 with ratio -1: its vx is |vy|·I1, its x the integral of that
  double slip_td_mps_;
  double slipping_ratio_;  // -F_x/F_y until the slip is zero
  double rolling_ratio_;   // -F_x/F_y from then on
  bool rolls_;             // friction suffices to hold it rolling
  std::optional<double> grip_fraction_;
  double grip_speed_mps_ = 0.0;  // |vy|·I1 at the grip
  double grip_length_m_ = 0.0;   // its integral up to the grip
};

}  // namespace strobe::contact
