#include "sim/plan/flight_bounds.hpp"

#include <cmath>
#include <numbers>

#include "common/flight/aerodynamics.hpp"
#include "sim/plan/displacement.hpp"

namespace strobe::sim {

/// A leg up to `t`, with the bounds that all effects share.
struct FlightBounds::Leg {
  LegMotion start;
  double t = 0.0;
  bool bounded = true;
  double v0 = 0.0;           ///< speed at the surface
  double v = 0.0;            ///< largest speed
  double pull = 0.0;         ///< largest acceleration
  double lipschitz = 0.0;    ///< of all effects
  double decayed = 0.0;      ///< largest share by which the spin changes
  double lift_change = 0.0;  ///< acceleration from that, at the leg's far end
};

FlightBounds::FlightBounds(const Scene& scene)
    : gravity_x_mps2_(-flight::kStandardGravity_mps2 * std::sin(scene.surface_angle_rad)),
      gravity_y_mps2_(-flight::kStandardGravity_mps2 * std::cos(scene.surface_angle_rad)),
      decay_pm_(scene.air.spin_decay_per_m),
      radius_m_(scene.ball.radius_m()) {
  const double density = scene.air.density_kgpm3 >= 0.0 ? scene.air.density_kgpm3
                                                        : flight::air_density_kgpm3(scene.air.temperature_c);
  air_pm_ = density * std::numbers::pi * radius_m_ * radius_m_ / (2.0 * scene.ball.mass_kg);
  drag_pm_ = air_pm_ * scene.air.drag_coefficient;
  lift_pm_ = scene.air.lift ? air_pm_ : 0.0;
}

FlightBounds::Leg FlightBounds::leg_of(const LegMotion& motion, double t) const {
  Leg leg{.start = motion, .t = t};
  const double gravity = flight::kStandardGravity_mps2;
  const double kappa = std::hypot(drag_pm_, 0.5 * lift_pm_);
  leg.v0 = std::hypot(motion.vx_mps, motion.vy_mps);
  const double fastest = leg.v0 + gravity * t;
  const double room = 1.0 - kappa * fastest * t;
  leg.bounded = room > 0.0;
  if (!leg.bounded) return leg;
  leg.v = fastest / room;
  leg.pull = gravity + kappa * leg.v * leg.v;
  leg.lipschitz = (2.0 * drag_pm_ + lift_pm_) * leg.v;
  leg.decayed = std::expm1(decay_pm_ * leg.v * t);
  const double rim = radius_m_ * std::abs(motion.omega_radps);
  const double least = 2.0 * rim / (1.0 + leg.decayed) + leg.v;
  leg.lift_change = lift_pm_ * leg.v * leg.v * leg.v / (least * least) * rim * leg.decayed;
  return leg;
}

BoundedDisplacement FlightBounds::displaced(const Leg& leg, double ax, double ay, double lipschitz) const {
  const double t = leg.t;
  const double changes = lipschitz * leg.pull;
  const double largest = std::hypot(ax, ay) + changes * t;
  const double off = (changes + leg.lipschitz * largest * std::exp(leg.lipschitz * t)) * t * t * t / 6.0;
  BoundedDisplacement d;
  d.by.x_m = 0.5 * ax * t * t;
  d.by.y_m = 0.5 * ay * t * t;
  d.within.x_m = d.within.y_m = off;
  d.within.equator_rad = std::abs(leg.start.omega_radps) * (1.0 + leg.decayed) * decay_pm_ * largest *
                         std::exp(leg.lipschitz * t) * t * t * t / 6.0;
  return d;
}

BoundedDisplacement FlightBounds::by_spin_decay(const Leg& leg) const {
  const double t = leg.t;
  const double omega = leg.start.omega_radps;
  const double first_order = decay_pm_ * leg.v * t;
  BoundedDisplacement d;
  d.by.equator_rad = -0.5 * omega * decay_pm_ * leg.v0 * t * t;
  d.within.equator_rad =
      std::abs(omega) * (leg.decayed - first_order + 0.5 * decay_pm_ * leg.pull * t * t) * t / 3.0;
  d.within.x_m = d.within.y_m =
      leg.lift_change * (1.0 + leg.lipschitz * t * std::exp(leg.lipschitz * t)) * t * t / 6.0;
  return d;
}

BoundedDisplacement FlightBounds::of(Effect effect, const LegMotion& motion, double time_s) const {
  const bool absent = (effect == Effect::drag && drag_pm_ == 0.0) ||
                      (effect == Effect::magnus && (lift_pm_ == 0.0 || motion.omega_radps == 0.0)) ||
                      (effect == Effect::spin_decay && (decay_pm_ == 0.0 || motion.omega_radps == 0.0));
  const bool flies = effect == Effect::gravity || effect == Effect::drag || effect == Effect::magnus ||
                     effect == Effect::spin_decay;
  if (absent || !flies) return {};
  const Leg leg = leg_of(motion, time_s);
  if (!leg.bounded) return {{}, {kNoBound, kNoBound, 0.0, kNoBound, 0.0}};
  if (effect == Effect::gravity) return displaced(leg, gravity_x_mps2_, gravity_y_mps2_, 0.0);
  if (effect == Effect::spin_decay) return by_spin_decay(leg);
  if (effect == Effect::drag) {
    const double k = drag_pm_ * leg.v0;
    return displaced(leg, -k * motion.vx_mps, -k * motion.vy_mps, 2.0 * drag_pm_ * leg.v);
  }
  const double rim = radius_m_ * motion.omega_radps;
  const double k = lift_pm_ * rim * leg.v0 / (2.0 * std::abs(rim) + leg.v0);
  BoundedDisplacement d = displaced(leg, -k * motion.vy_mps, k * motion.vx_mps, lift_pm_ * leg.v);
  d.within.x_m += leg.lift_change * (1.0 + leg.decayed) * time_s * time_s / 6.0;
  d.within.y_m = d.within.x_m;
  return d;
}

}  // namespace strobe::sim
