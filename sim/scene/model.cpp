#include "sim/scene/model.hpp"

#include <optional>
#include <utility>

namespace strobe::sim {

namespace {

std::string known_effects() {
  std::string names;
  for (const std::string_view effect : kEffectNames) names.append(names.empty() ? "" : ", ").append(effect);
  return names;
}

Result<Model> with_word(const Model& model, std::string_view word, bool on) {
  const std::optional<Effect> effect = effect_from_name(word);
  if (effect) return model.with(*effect, on);
  std::string what = "\"";
  what.append(word).append("\" is no effect; there are ").append(known_effects());
  return fail(std::move(what));
}

}  // namespace

Result<Model> parse_model(std::string_view text) {
  if (text == "full") return Model::full();
  if (text == "none") return Model::none();
  if (text.starts_with("full-")) text.remove_prefix(4);
  const bool leaves_out = text.starts_with('-');
  Result<Model> model = leaves_out ? Model::full() : Model::none();
  while (model) {
    if (leaves_out && text.starts_with('-')) text.remove_prefix(1);
    const std::size_t end = text.find_first_of(leaves_out ? ",-" : ",");
    model = with_word(*model, text.substr(0, end), !leaves_out);
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return model;
}

std::string model_text(const Model& model) {
  if (model == Model::full()) return "full";
  if (model == Model::none()) return "none";
  std::size_t on = 0;
  for (std::size_t i = 0; i < kEffectCount; ++i) on += model.has(static_cast<Effect>(i)) ? 1U : 0U;
  const bool leaves_out = 2 * on > kEffectCount;
  std::string text;
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    if (model.has(static_cast<Effect>(i)) == leaves_out) continue;
    if (!text.empty()) text += ',';
    if (leaves_out) text += '-';
    text += kEffectNames[i];
  }
  return text;
}

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
