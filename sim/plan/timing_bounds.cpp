#include "sim/plan/timing_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/flight/aerodynamics.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

constexpr double kClockTick_s = 1e-9;

double density_kgpm3(const AirSettings& air) {
  return air.density_kgpm3 >= 0.0 ? air.density_kgpm3 : flight::air_density_kgpm3(air.temperature_c);
}

}  // namespace

TimingBounds::TimingBounds(const Scene& scene)
    : delay_s_(scene.lamps.delay_s),
      jitter_s_(kLargestNormal * scene.lamps.jitter_s),
      sensor_jitter_s_(kLargestNormal * scene.sensors.jitter_s),
      flash_s_(scene.lamps.flash_s),
      decay_pm_(scene.air.spin_decay_per_m) {
  const double area_m2 = std::numbers::pi * scene.ball.radius_m() * scene.ball.radius_m();
  air_pm_ = density_kgpm3(scene.air) * area_m2 / (2.0 * scene.ball.mass_kg) *
            std::hypot(scene.air.drag_coefficient, 0.5);
  const double mu = scene.bounce.mu + kLargestNormal * scene.bounce.mu_sd;
  const double dwell_s =
      std::max(0.5 * scene.bounce.dwell_s, scene.bounce.dwell_s - kLargestNormal * scene.bounce.dwell_sd_s);
  contact_pull_ps_ = 2.0 * std::numbers::pi * (1.0 + mu) / dwell_s;
}

double TimingBounds::common_shift_s(Effect effect) const {
  if (effect == Effect::lamp_delay) return delay_s_;
  return effect == Effect::flash_duration ? 0.5 * flash_s_ : 0.0;
}

double TimingBounds::shift_s(Effect effect) const {
  if (effect == Effect::lamp_jitter) return jitter_s_;
  if (effect == Effect::lamp_delay && delay_s_ < jitter_s_) return delay_s_;
  return 0.0;
}

BoundedDisplacement TimingBounds::of(Effect effect, const LegMotion& leg, double time_s) const {
  BoundedDisplacement d;
  if (effect == Effect::sensor_delay && sensor_jitter_s_ > 0.0)
    d.within.time_s = sensor_jitter_s_ + kClockTick_s;
  if (effect == Effect::flash_duration && flash_s_ > 0.0) {
    const double v = std::hypot(leg.vx_mps, leg.vy_mps) + flight::kStandardGravity_mps2 * time_s;
    const double grown = v / std::max(0.1, 1.0 - air_pm_ * v * time_s);
    const double contact = time_s < flash_s_ ? contact_pull_ps_ * std::abs(leg.vy_mps) : 0.0;
    const double pull = flight::kStandardGravity_mps2 + air_pm_ * grown * grown + contact;
    const double square = flash_s_ * flash_s_ / 24.0;
    d.within.x_m = d.within.y_m = pull * square;
    d.within.equator_rad = decay_pm_ * grown * std::abs(leg.omega_radps) * square;
  }
  return d;
}

}  // namespace strobe::sim
