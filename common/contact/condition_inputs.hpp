// A condition of the thesis (Tables 2–10) as inputs of the contact analysis. Pure; thread-safe.
#pragma once

#include "common/contact/peaks.hpp"
#include "common/contact/standard_error.hpp"
#include "common/contact/stiffness.hpp"
#include "common/data/thesis_data.hpp"

namespace strobe::contact {

/// Means in SI units. `mu` is the condition's impulse ratio, which is the coefficient of friction only where
/// the ball slides throughout, else a lower bound of it.
inline SpinPulseInput spin_pulse_input(const thesis::Condition& c, impact::PulseForm form,
                                       double alpha = ball::kMeasuredAlpha) {
  SpinPulseInput in;
  in.ball.alpha = alpha;
  in.touchdown = {c.vx_td_mps.mean, c.vy_td_mps.mean, c.omega_td_radps.mean};
  in.e = c.e.mean;
  in.mu = c.mu.mean;
  in.dwell_s = c.dwell_time_ms.mean / 1e3;
  in.form = form;
  return in;
}

/// The published replicate sds (of one shot; over sqrt(n - 1) for the means). The diameter's tolerance, the
/// mass and alpha are left at 0: they are systematic.
inline SpinPulseSd spin_pulse_sd(const thesis::Condition& c) {
  SpinPulseSd sd;
  sd.vx_mps = c.vx_td_mps.sd;
  sd.vy_mps = c.vy_td_mps.sd;
  sd.omega_radps = c.omega_td_radps.sd;
  sd.e = c.e.sd;
  sd.mu = c.mu.sd;
  sd.dwell_s = c.dwell_time_ms.sd / 1e3;
  return sd;
}

inline EndVelocities end_velocities(const thesis::Condition& c) {
  const auto of = [](const thesis::MeanSd& m) { return ValueSd{m.mean, m.sd}; };
  return {of(c.vx_td_mps), of(c.vx_lo_mps),      of(c.vy_td_mps),
          of(c.vy_lo_mps), of(c.omega_td_radps), of(c.omega_lo_radps)};
}

inline FractionScale fraction_scale(const thesis::Condition& c) {
  return {.dwell_distance_m = c.dwell_distance_cm.mean / 1e2, .total_rotation_rad = std::nullopt};
}

}  // namespace strobe::contact
