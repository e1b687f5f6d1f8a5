#include "sim/plan/scene_bounds.hpp"

namespace strobe::sim {

std::array<bool, kEffectCount> effects_of(const Scene& scene) {
  const BounceSettings& b = scene.bounce;
  const bool ode = b.contact == ContactLaw::ode;
  const bool air = scene.air.density_kgpm3 != 0.0;
  const bool ahead =
      ode ? b.offset_share > 0.0 || b.offset_share_sd > 0.0 : b.offset_m > 0.0 || b.offset_sd_m > 0.0;
  const ShutterSettings& shutter = scene.shutter;
  return {true,  // gravity
          air && scene.air.drag_coefficient > 0.0,
          air && scene.air.lift,
          scene.air.spin_decay_per_m > 0.0,
          true,  // the weight during contact
          true,  // grip
          ahead,
          ode || b.ex != 0.0 || b.ex_sd > 0.0,
          ode,
          scene.lamps.flash_s > 0.0,
          scene.lamps.delay_s > 0.0,
          scene.lamps.jitter_s > 0.0,
          scene.sensors.delay_s > 0.0 || scene.sensors.jitter_s > 0.0,
          shutter.open_lag_s > 0.0 || shutter.close_lag_s > 0.0 || shutter.lag_sd_s > 0.0,
          scene.camera.distance_m > 0.0,
          scene.camera.distortion != 0.0,
          scene.camera.pixels};
}

}  // namespace strobe::sim
