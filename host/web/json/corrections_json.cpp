#include "host/web/json/corrections_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace strobe::web {
namespace {

using digitize::Correction;
using digitize::ManualMeasurement;
using digitize::ManualPoint;
using digitize::PlaneMap;
using nlohmann::ordered_json;

constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;

cv::Point2d photographed(const ManualPoint& p, const PlaneMap& map) {
  return p.in_image ? p.point : map.to_image(p.point);
}

ordered_json point_json(const ManualPoint& p, const PlaneMap& map) {
  const cv::Point2d at = photographed(p, map);
  return {at.x, at.y};
}

double photographed_deg(double plane_rad, const PlaneMap& map, cv::Point2d at) {
  const cv::Vec2d along = map.jacobian(at).inv() * cv::Vec2d(std::cos(plane_rad), std::sin(plane_rad));
  return std::atan2(-along[1], along[0]) * kDegreesPerRad;
}

void put(ordered_json& json, const char* key, const std::optional<double>& value) {
  if (value) json[key] = *value;
}

/// at: where the image is, on the photograph.
void put_measured(ordered_json& json, const ManualMeasurement& m, const PlaneMap& map, cv::Point2d at) {
  if (m.centre) json["centre_px"] = point_json(*m.centre, map);
  put(json, "centre_sd_px", m.centre_sd_px);
  if (m.diameter_px)
    json["diameter_px"] = *m.diameter_px * (m.diameter_in_image ? 1.0 : map.image_px_per_plane_px(at));
  put(json, "diameter_sd_px", m.diameter_sd_px);
  if (m.equator_rad)
    json["equator_deg"] =
        m.equator_in_image ? *m.equator_rad * kDegreesPerRad : photographed_deg(*m.equator_rad, map, at);
  if (m.equator_sd_rad) json["equator_sd_deg"] = *m.equator_sd_rad * kDegreesPerRad;
  if (m.no_equator) json["no_equator"] = true;
  if (m.leg) json["leg"] = name(*m.leg);
  if (m.top) json["top_px"] = point_json(*m.top, map);
  put(json, "contact_width_px", m.contact_width_px);
  put(json, "time_s", m.time_s);
}

std::string_view word(Correction::Kind kind) {
  switch (kind) {
    case Correction::Kind::add:
      return "add";
    case Correction::Kind::move:
      return "move";
    case Correction::Kind::remove:
      return "remove";
    case Correction::Kind::surface:
      return "surface";
  }
  return "";
}

ordered_json correction_json(const Correction& correction, const PlaneMap& map) {
  using Kind = Correction::Kind;
  ordered_json json{{"kind", word(correction.kind)}};
  if (correction.kind == Kind::surface) {
    json["left_px"] = point_json(correction.surface.left, map);
    json["right_px"] = point_json(correction.surface.right, map);
    put(json, "sd_px", correction.surface.sd_px);
    return json;
  }
  const bool is_found = correction.kind != Kind::add;
  if (is_found) json["at_px"] = point_json(correction.at, map);
  const ManualMeasurement& m = correction.measured;
  put_measured(json, m, map, photographed(m.centre ? *m.centre : correction.at, map));
  return json;
}

}  // namespace

ordered_json corrections_json(std::span<const Correction> corrections, const PlaneMap& map) {
  ordered_json list = ordered_json::array();
  for (const Correction& each : corrections) list.push_back(correction_json(each, map));
  return list;
}

}  // namespace strobe::web
