#include "sim/scene/reduced_scene.hpp"

namespace strobe::sim {

Scene reduced_scene(const Scene& scene, const Model& model) {
  Scene left = scene;
  if (!model.has(Effect::drag)) left.air.drag_coefficient = 0.0;
  if (!model.has(Effect::magnus)) left.air.lift = false;
  if (!model.has(Effect::spin_decay)) left.air.spin_decay_per_m = 0.0;
  if (!model.has(Effect::flash_duration)) left.lamps.flash_s = 0.0;
  if (!model.has(Effect::lamp_delay)) left.lamps.delay_s = 0.0;
  if (!model.has(Effect::lamp_jitter)) left.lamps.jitter_s = 0.0;
  if (!model.has(Effect::sensor_delay)) left.sensors.delay_s = left.sensors.jitter_s = 0.0;
  if (!model.has(Effect::shutter_lag))
    left.shutter.open_lag_s = left.shutter.close_lag_s = left.shutter.lag_sd_s = 0.0;
  if (!model.has(Effect::perspective)) left.camera.distance_m = 0.0;
  if (!model.has(Effect::lens_distortion)) left.camera.distortion = 0.0;
  if (!model.has(Effect::pixels)) left.camera.pixels = false;
  return left;
}

}  // namespace strobe::sim
