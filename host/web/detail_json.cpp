#include "host/web/detail_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/config/files.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/report/hashes.hpp"
#include "host/series/select.hpp"
#include "host/session/advice.hpp"
#include "host/session/shot.hpp"
#include "host/session/shot_table.hpp"
#include "host/view/series_json.hpp"
#include "host/view/spatial_view.hpp"
#include "host/web/images_json.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {
namespace {

using host::Digitization;
using host::Shot;
using nlohmann::ordered_json;

ordered_json flag_words_json(const host::Shot& result) {
  ordered_json words = ordered_json::array();
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (result.readout.flags.has(flag))
      words.push_back(host::words(flag, result.readout, result.train.faults));
  }
  return words;
}

ordered_json digitizations_json(const Shot& shot) {
  ordered_json list = ordered_json::array();
  for (const Digitization& each : shot.digitizations)
    list.push_back({{"utc", each.utc},
                    {"who", each.who.empty() ? ordered_json() : ordered_json(each.who)},
                    {"kind", host::digitization_word(each)},
                    {"images", each.frame.images.size()},
                    {"counts", &each == &shot.digitizations.back()}});
  return list;
}

/// The corrections in force, as they were typed.
ordered_json corrections_text_json(const Shot& shot) {
  if (shot.digitizations.empty() || shot.digitizations.back().corrections.empty()) return nullptr;
  const auto text = config::read_file(shot.digitizations.back().corrections.string());
  return text ? ordered_json(*text) : ordered_json();
}

/// The file of the digitization that counts; null: the log holds it.
ordered_json kept_digitization(const Shot& shot) {
  if (shot.digitizations.empty() || shot.digitizations.back().file.empty()) return nullptr;
  const auto text = config::read_file(shot.digitizations.back().file.string());
  auto kept = text ? messages::parsed_json<ordered_json>(*text) : ordered_json();
  return kept.is_discarded() ? ordered_json() : kept;
}

/// What it left out.
ordered_json kept_unmeasured_json(const ordered_json& kept, const digitize::PlaneMap& map) {
  if (!kept.is_object() || !kept.contains("unmeasured") || !kept["unmeasured"].is_array()) return nullptr;
  ordered_json list = ordered_json::array();
  for (const ordered_json& each : kept["unmeasured"]) {
    if (!each.is_object()) continue;
    const auto number = [](const ordered_json& value) {
      return value.is_number() ? value.get<double>() : std::nan("");
    };
    const auto word = [&each](const char* key) {
      return each.contains(key) && each[key].is_string() ? each[key].get<std::string>() : std::string();
    };
    const ordered_json centre = each.value("centre_px", ordered_json());
    if (!centre.is_array() || centre.size() != 2) continue;
    const cv::Point2d at = map.to_image({number(centre[0]), number(centre[1])});
    const double diameter = number(each.value("diameter_px", ordered_json(0.0)));
    if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(diameter)) continue;
    const std::string detail = word("detail");
    list.push_back({{"what", word("what")},
                    {"centre_px", {at.x, at.y}},
                    {"diameter_px", diameter * map.image_px_per_plane_px(at)},
                    {"why", word("reason") + (detail.empty() ? "" : ": " + detail)}});
  }
  return list;
}

}  // namespace

digitize::PlaneMap photograph_map(const Shot& shot, const std::optional<PhotographPlace>& photograph) {
  int height_px = photograph ? photograph->height_px : shot.rig->camera.height_px.value_or(0);
  if (height_px <= 0 && !shot.digitizations.empty()) {
    double top = 0.0;
    for (const auto& image : shot.digitizations.back().frame.images)
      top = std::max(top, image.centre_y_px + (std::isfinite(image.diameter_px) ? image.diameter_px : 0.0));
    height_px = static_cast<int>(std::min(top, 1e6)) + 1;
  }
  return host::plane_map(shot.rig->camera, height_px);
}

ordered_json detail_json(const Shot& shot, const std::string& session_id,
                         const std::optional<PhotographPlace>& photograph) {
  ordered_json object = shot_json(shot_row(shot), session_id);
  object["readout"] = messages::readout_json(shot.readout);
  object["problem"] = shot.problem.empty() ? ordered_json() : ordered_json(shot.problem);
  object["flag_words"] = flag_words_json(shot);
  object["advice"] = host::advice(shot);
  object["spatial_words"] = host::spatial_words(shot.readout);
  const std::string drawing = host::spin_drawing(shot.readout);
  object["spin_axis"] =
      drawing.empty()
          ? ordered_json()
          : ordered_json("data:image/svg+xml;base64," +
                         report::base64(std::vector<std::uint8_t>(drawing.begin(), drawing.end())));
  object["verified"] = shot.verified;
  object["photograph"] = photograph ? ordered_json{{"url", photograph->url},
                                                   {"width_px", photograph->width_px},
                                                   {"height_px", photograph->height_px}}
                                    : ordered_json();
  const digitize::PlaneMap map = photograph_map(shot, photograph);
  object["images"] = ordered_json::array();
  const ordered_json kept = kept_digitization(shot);
  object["unmeasured"] = kept_unmeasured_json(kept, map);
  object["surface_px"] = nullptr;
  if (!shot.digitizations.empty()) {
    const auto& frame = shot.digitizations.back().frame;
    object["images"] =
        images_json(shot.summary ? &*shot.summary : nullptr, frame, host::assembly_settings(*shot.rig), map);
    object["surface_px"] = surface_json(frame, map);
  }
  object["ball_diameter_m"] = shot.rig->ball.diameter_m;
  object["surface_by_hand"] = kept.is_object() && kept.value("surface_source", ordered_json()) == "hand";
  object["digitizations"] = digitizations_json(shot);
  object["corrections"] = corrections_text_json(shot);
  object["budget"] = host::budget_json(host::budget_of(shot), shot.readout);
  object["train"] = train_report_json(shot.train, shot.shot_id);
  object["train"]["dry"] = shot.dry;
  return object;
}

}  // namespace strobe::web
