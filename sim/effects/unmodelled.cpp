#include "sim/effects/unmodelled.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/flight/aerodynamics.hpp"
#include "common/flight/gravity.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

using reduction::Quantity;

constexpr double kEarth_radps = 7.2921e-5;
constexpr double kLongestLeg_s = 0.25;

/// The fastest ball of the scene, and how long it is seen.
struct Extremes {
  double speed_mps, vy_mps, spin_radps, dwell_s, leg_s;

  explicit Extremes(const Scene& scene) {
    const MachineSettings& m = scene.machine;
    const BounceSettings& b = scene.bounce;
    speed_mps = m.speed_mps + kLargestNormal * m.speed_sd_mps;
    const double steepest =
        std::min(std::abs(m.angle_rad) + kLargestNormal * m.angle_sd_rad, 0.5 * std::numbers::pi);
    vy_mps = speed_mps * std::sin(steepest);
    dwell_s = std::min(1.5 * b.dwell_s, b.dwell_s + kLargestNormal * b.dwell_sd_s);
    // At lift-off no more than friction and the offset at their limits add.
    const double lever = b.mu + kLargestNormal * b.mu_sd + 1.0;
    spin_radps = std::hypot(m.spin_radps, m.sidespin_radps, m.gyrospin_radps) +
                 kLargestNormal * std::hypot(m.spin_sd_radps, m.sidespin_sd_radps, m.gyrospin_sd_radps) +
                 lever * 2.0 * vy_mps / (scene.ball.alpha * scene.ball.radius_m());
    const double along_mps = speed_mps * std::cos(m.angle_rad);
    leg_s = std::min(kLongestLeg_s, 1.2 * scene.camera.half_width_m / std::max(along_mps, 1e-3));
  }
};

double density_of(const AirSettings& air) {
  return air.density_kgpm3 >= 0.0 ? air.density_kgpm3 : flight::air_density_kgpm3(air.temperature_c);
}

}  // namespace

std::vector<UnmodelledTerm> unmodelled_terms(const Scene& scene) {
  const Extremes x(scene);
  const double radius = scene.ball.radius_m(), density = density_of(scene.air);
  const double q = density * std::numbers::pi * radius * radius / (2.0 * scene.ball.mass_kg);
  const double drag_mps2 = q * scene.air.drag_coefficient * x.speed_mps * x.speed_mps;
  const double lift_mps2 =
      scene.air.lift ? scene.air.lift_factor / scene.air.lift_slope * q * x.speed_mps * x.speed_mps : 0.0;
  const double displaced =
      density * 4.0 / 3.0 * std::numbers::pi * radius * radius * radius / scene.ball.mass_kg;
  const double flattened = x.vy_mps * x.dwell_s / (std::numbers::pi * radius);
  const double along_mps2 = scene.bounce.contact == ContactLaw::grip
                                ? flight::kStandardGravity_mps2 * std::abs(std::sin(scene.surface_angle_rad))
                                : 0.0;
  const double gravity = flight::kStandardGravity_mps2;
  std::vector<UnmodelledTerm> terms{
      {"drag_in_contact", Quantity::v_lo_mps, drag_mps2 * x.dwell_s},
      {"lift_in_contact", Quantity::v_lo_mps, lift_mps2 * x.dwell_s},
      {"spin_decay_in_contact", Quantity::omega_lo_radps,
       scene.air.spin_decay_per_m * x.speed_mps * x.spin_radps * x.dwell_s},
      {"flattening_in_drag", Quantity::v_lo_mps, drag_mps2 * x.dwell_s * flattened},
      {"buoyancy", Quantity::v_lo_mps, displaced * gravity * x.leg_s},
      {"air_moved_along", Quantity::v_lo_mps, 0.5 * displaced * (gravity + drag_mps2) * x.leg_s},
      {"earth_rotation", Quantity::v_lo_mps, 2.0 * kEarth_radps * x.speed_mps * x.leg_s},
      {"weight_along_plate", Quantity::vx_lo_mps, along_mps2 * x.dwell_s}};
  std::erase_if(terms, [](const UnmodelledTerm& term) { return !(term.bound > 0.0); });
  return terms;
}

}  // namespace strobe::sim
