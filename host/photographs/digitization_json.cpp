#include "host/photographs/digitization_json.hpp"

#include <nlohmann/json.hpp>

#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {
namespace {

using digitize::DigitizeSettings;
using nlohmann::ordered_json;

ordered_json inputs_json(const DigitizeSettings& settings) {
  ordered_json inputs;
  inputs["px_per_m"] = messages::or_null(settings.px_per_m);
  inputs["px_per_m_sd"] = messages::or_null(settings.px_per_m_sd);
  inputs["ball_diameter_m"] = settings.ball_diameter_m;
  inputs["ball_diameter_sd_m"] = messages::or_null(settings.ball_diameter_sd_m);
  inputs["size_tolerance_percent"] = 100.0 * settings.size_tolerance;
  inputs["calibrated"] = !settings.map.is_uncalibrated();
  inputs["flashes"] =
      settings.flash_times_s ? ordered_json(settings.flash_times_s->size()) : ordered_json(nullptr);
  inputs["effort"] = name(settings.effort);
  inputs["direction"] = !settings.leftwards ? "auto" : *settings.leftwards ? "left" : "right";
  inputs["line_drawn"] = settings.line_drawn;
  inputs["bounce"] = messages::or_null(settings.bounce);
  return inputs;
}

ordered_json scale_json(const digitize::BallScale& scale) {
  return {{"px_per_m", scale.px_per_m},
          {"px_per_m_sd", scale.px_per_m_sd},
          {"diameter_px", scale.diameter_px},
          {"diameter_sd_px", scale.diameter_sd_px},
          {"images", scale.images}};
}

ordered_json rejection_json(const digitize::Rejection& why) {
  return {{"reason", digitize::name(why.reason)}, {"detail", why.detail}};
}

ordered_json unmeasured_json(const digitize::Unmeasured& unmeasured) {
  ordered_json object;
  object["what"] = unmeasured.what;
  object["centre_px"] = {unmeasured.centre.x, unmeasured.centre.y};
  object["diameter_px"] = unmeasured.diameter;
  object.update(rejection_json(unmeasured.why));
  return object;
}

}  // namespace

std::string digitization_json(const digitize::Digitization& digitization, const std::string& photograph,
                              const DigitizeSettings& settings, bool explain) {
  ordered_json more;
  more["photograph"] = photograph;
  more["inputs"] = inputs_json(settings);
  if (digitization.scale) more["scale"] = scale_json(*digitization.scale);
  if (digitization.no_surface) more["no_surface"] = rejection_json(*digitization.no_surface);
  if (digitization.surface_by_hand) more["surface_source"] = "hand";
  if (!digitization.remarks.empty()) more["remarks"] = digitization.remarks;
  if (explain) {
    more["unmeasured"] = ordered_json::array();
    for (const auto& unmeasured : digitization.unmeasured)
      more["unmeasured"].push_back(unmeasured_json(unmeasured));
  }
  std::string line = messages::frame_to_json(digitization.frame);
  line.back() = ',';
  return line + messages::json_text(more).substr(1);
}

}  // namespace strobe::host
