#include "sim/plan/scene_bounds.hpp"

namespace strobe::sim {

bool scene_has(const Scene& scene, Effect effect) {
  const BounceSettings& b = scene.bounce;
  const bool ode = b.contact == ContactLaw::ode;
  const CameraSettings& c = scene.camera;
  switch (effect) {
    case Effect::gravity:
    case Effect::grip:
    case Effect::contact_gravity:
      return true;
    case Effect::drag:
      return scene.air.drag_coefficient > 0.0 && scene.air.density_kgpm3 != 0.0;
    case Effect::magnus:
      return scene.air.lift && scene.air.density_kgpm3 != 0.0;
    case Effect::spin_decay:
      return scene.air.spin_decay_per_m > 0.0;
    case Effect::offset:
      return ode ? b.offset_share > 0.0 || b.offset_share_sd > 0.0 : b.offset_m > 0.0 || b.offset_sd_m > 0.0;
    case Effect::tangential_compliance:
      return ode || b.ex != 0.0 || b.ex_sd > 0.0;
    case Effect::contact_ode:
      return ode;
    case Effect::flash_duration:
      return scene.lamps.flash_s > 0.0;
    case Effect::lamp_delay:
      return scene.lamps.delay_s > 0.0;
    case Effect::lamp_jitter:
      return scene.lamps.jitter_s > 0.0;
    case Effect::sensor_delay:
      return scene.sensors.delay_s > 0.0 || scene.sensors.jitter_s > 0.0;
    case Effect::shutter_lag:
      return scene.shutter.open_lag_s > 0.0 || scene.shutter.close_lag_s > 0.0 ||
             scene.shutter.lag_sd_s > 0.0;
    case Effect::perspective:
      return c.distance_m > 0.0;
    case Effect::lens_distortion:
      return c.distortion != 0.0;
    case Effect::pixels:
      return c.pixels;
  }
  return true;
}

}  // namespace strobe::sim
