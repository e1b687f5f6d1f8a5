#include "common/contact/spin_pulse.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strobe::contact {

namespace {

using impact::InputError;

std::optional<InputError> find_error(const SpinPulseInput& in) {
  if (!std::isfinite(in.offset_m)) return InputError::not_finite;
  // rigid() checks everything else that the pulse does not.
  const auto rebound = impact::rigid(in.ball, in.touchdown, in.e, in.mu);
  if (!rebound) return rebound.error();
  if (!(std::abs(in.offset_m) < in.ball.radius_m())) return InputError::offset_out_of_range;
  return std::nullopt;
}

bool finite(const SpinPulseState& s) {
  return std::isfinite(s.x_m) && std::isfinite(s.y_m) && std::isfinite(s.rotation_rad) &&
         std::isfinite(s.vx_mps) && std::isfinite(s.vy_mps) && std::isfinite(s.omega_radps) &&
         std::isfinite(s.slip_mps) && std::isfinite(s.fx_n) && std::isfinite(s.fy_n);
}

}  // namespace

tl::expected<SpinPulse, InputError> SpinPulse::make(const SpinPulseInput& input) {
  if (const auto error = find_error(input)) return tl::unexpected(*error);
  const auto unit = impact::SinePulse::make(input.form, {.vx_td_mps = 0.0,
                                                         .vy_td_mps = input.touchdown.vy_mps,
                                                         .e = input.e,
                                                         .impulse_ratio = -1.0,
                                                         .dwell_s = input.dwell_s,
                                                         .mass_kg = input.ball.mass_kg});
  if (!unit) return tl::unexpected(unit.error());
  const SpinPulse pulse(input, *unit);
  if (!finite(pulse.at_fraction(0.5)) || !finite(pulse.at_fraction(1.0)))
    return tl::unexpected(InputError::magnitude_out_of_range);
  return pulse;
}

SpinPulse::SpinPulse(const SpinPulseInput& input, const impact::SinePulse& unit)
    : input_(input), unit_(unit) {
  const double radius = input.ball.radius_m();
  // The slip of a nearly rolling ball is the small difference of large numbers: one rounding only.
  slip_td_mps_ = std::fma(radius, input.touchdown.omega_radps, input.touchdown.vx_mps);
  slipping_ratio_ = std::copysign(input.mu, slip_td_mps_);
  const double needed = input.offset_m / (radius * (1.0 + input.ball.alpha));
  rolling_ratio_ = std::clamp(needed, -input.mu, input.mu);
  rolls_ = rolling_ratio_ == needed;
  find_grip();
}

/// The slip falls by `rate` for each m/s of normal impulse per mass.
void SpinPulse::find_grip() {
  const double alpha = input_.ball.alpha;
  const double rate = (slipping_ratio_ * (1.0 + alpha) - input_.offset_m / input_.ball.radius_m()) / alpha;
  const double whole = -(1.0 + input_.e) * input_.touchdown.vy_mps;
  if (slip_td_mps_ == 0.0) {
    grip_fraction_ = 0.0;
    return;
  }
  // Compared before it is divided, which might overflow.
  const bool stops = rate * slip_td_mps_ > 0.0 && std::abs(slip_td_mps_) < std::abs(rate) * whole;
  if (!stops) return;
  const double needed = slip_td_mps_ / rate;
  grip_fraction_ = unit_.fraction_at_impulse(needed / whole);
  grip_speed_mps_ = needed;
  grip_length_m_ = unit_.at_fraction(*grip_fraction_).x_m;
}

Regime SpinPulse::regime() const { return grip_fraction_ && rolls_ ? Regime::grips : Regime::slides; }

double SpinPulse::largest_force_fraction() const { return std::atan2(1.0, damping()) / std::numbers::pi; }

double SpinPulse::deepest_fraction() const {
  return input_.form == impact::PulseForm::simplified ? largest_force_fraction()
                                                      : unit_.fraction_at_impulse(1.0 / (1.0 + input_.e));
}

SpinPulseState SpinPulse::at_fraction(double asked_fraction) const {
  const double time_fraction = std::clamp(asked_fraction, impact::kMinTimeFraction, impact::kMaxTimeFraction);
  const impact::PulseState normal = unit_.at_fraction(time_fraction);
  const double radius = input_.ball.radius_m();
  const double alpha = input_.ball.alpha;
  const double lever = input_.offset_m / radius;
  const double time_s = time_fraction * input_.dwell_s;
  const bool slipping = !grip_fraction_ || time_fraction < *grip_fraction_;

  // Normal impulse per mass, and its integral, before and after the grip.
  double before_mps = normal.vx_mps, after_mps = 0.0, before_m = normal.x_m, after_m = 0.0;
  if (!slipping) {
    const double rolled_m = grip_speed_mps_ * (time_fraction - *grip_fraction_) * input_.dwell_s;
    before_mps = grip_speed_mps_;
    after_mps = normal.vx_mps - grip_speed_mps_;
    before_m = grip_length_m_ + rolled_m;
    after_m = normal.x_m - grip_length_m_ - rolled_m;
  }
  const double friction_mps = slipping_ratio_ * before_mps + rolling_ratio_ * after_mps;
  const double friction_m = slipping_ratio_ * before_m + rolling_ratio_ * after_m;
  const double spin_change_mps = (lever * normal.vx_mps - friction_mps) / alpha;  // R·(omega - omega_TD)
  const double rotation_change_m = (lever * normal.x_m - friction_m) / alpha;

  SpinPulseState s;
  s.x_m = input_.touchdown.vx_mps * time_s - friction_m;
  s.y_m = normal.y_m;
  s.rotation_rad = input_.touchdown.omega_radps * time_s + rotation_change_m / radius;
  s.vx_mps = input_.touchdown.vx_mps - friction_mps;
  s.vy_mps = normal.vy_mps;
  s.omega_radps = input_.touchdown.omega_radps + spin_change_mps / radius;
  s.fy_n = normal.fy_n;
  s.fx_n = 0.0 - (slipping ? slipping_ratio_ : rolling_ratio_) * normal.fy_n;
  if (slipping || !rolls_) s.slip_mps = slip_td_mps_ - friction_mps + spin_change_mps;
  return s;
}

}  // namespace strobe::contact
