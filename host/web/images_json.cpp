#include "host/web/images_json.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/messages/lcm_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/reduction/reduce.hpp"

namespace strobe::web {
namespace {

using digitize::Correction;
using digitize::ManualMeasurement;
using digitize::ManualPoint;
using digitize::PlaneMap;
using messages::or_null;
using nlohmann::ordered_json;
using reduction::BallImage;
using reduction::Leg;

ordered_json point_json(cv::Point2d p) { return {p.x, p.y}; }

/// One image with what became of it.
struct Judged {
  bool used = false;
  std::string why_not;
  std::optional<Leg> leg;
  std::optional<int> flash;
  std::optional<double> time_s, residual_px;
  bool diameter_used = false, equator_used = false;
};

/// 99.9 % is not 100 %.
std::string how_likely(const BallImage& image) {
  if (!image.probability || image.source == "hand") return "";
  return fmt::format("; the digitizer gives it {:.0f} % of being a ball's",
                     std::floor(100.0 * *image.probability + 1e-9));
}

std::string why_left_out(const reduction::ImageFit& fit, const BallImage& image) {
  if (fit.leg == Leg::contact) return "in contact with the surface: it belongs to no flight";
  if (fit.residual_px)
    return fmt::format("left out: it lies {:.2g} px from where the others say the ball was{}",
                       *fit.residual_px, how_likely(image));
  return fit.leg ? "its leg has too few images" : "on neither leg of the path";
}

/// Of a frame whose images were all matched with flashes, but for those that the assembly left out.
void judge_matched(const host::AssembledShot& assembled, const reduction::Frame& frame,
                   std::vector<Judged>& judged) {
  const auto fits = reduction::image_fits(assembled.frame);
  std::size_t next = 0;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    Judged& image = judged[i];
    const auto& kept = assembled.frame.images;
    const bool is_kept = next < kept.size() && kept[next].centre_px.x == frame.images[i].centre_px.x &&
                         kept[next].centre_px.y == frame.images[i].centre_px.y;
    if (!is_kept) {
      image.why_not = "left out: no flash made it where it is, as the other images' flashes tell";
      continue;
    }
    image.flash = kept[next].flash_index;
    image.time_s = kept[next].time_s;
    if (fits) {
      const reduction::ImageFit& fit = (*fits)[next];
      image.leg = fit.leg;
      image.used = fit.centre_used;
      image.residual_px = fit.residual_px;
      image.diameter_used = fit.diameter_used;
      image.equator_used = fit.equator_used;
      if (!fit.centre_used) image.why_not = why_left_out(fit, frame.images[i]);
    } else {
      image.why_not = fits.error().message;
    }
    ++next;
  }
}

std::vector<Judged> judge(const strobe_msgs::shot_t* summary, const strobe_msgs::frame_t& message,
                          const reduction::Frame& frame, const host::AssemblySettings& settings) {
  std::vector<Judged> judged(frame.images.size());
  if (summary == nullptr) {
    for (Judged& image : judged) image.why_not = "the shot's flashes are not known";
    return judged;
  }
  const host::AssembledShot assembled = assemble(*summary, message, settings);
  if (assembled.frame.images.empty()) {
    for (Judged& image : judged)
      image.why_not = assembled.problem.empty() ? "no flashes match the images" : assembled.problem;
    return judged;
  }
  judge_matched(assembled, frame, judged);
  return judged;
}

/// Direction of the equator's line on the photograph, counter-clockwise from its right as seen.
double photographed_angle_rad(double plane_rad, const PlaneMap& map, cv::Point2d at) {
  const cv::Vec2d along = map.jacobian(at).inv() * cv::Vec2d(std::cos(plane_rad), std::sin(plane_rad));
  return std::atan2(-along[1], along[0]);
}

/// 0 to pi: a line has no sense.
double photographed_equator_rad(double plane_rad, const PlaneMap& map, cv::Point2d at) {
  const double angle = photographed_angle_rad(plane_rad, map, at);
  return angle < 0.0 ? angle + std::numbers::pi : angle;
}

std::optional<double> centre_sd(const BallImage& image, const reduction::Frame& frame) {
  if (!image.centre_cov_px2) return frame.centre_sd_px;
  return std::sqrt(std::max({0.0, (*image.centre_cov_px2)[0], (*image.centre_cov_px2)[3]}));
}

/// Of column and row, row-major.
ordered_json covariance_json(const BallImage& image, const PlaneMap& map, cv::Point2d at) {
  if (!image.centre_cov_px2) return nullptr;
  const auto& c = *image.centre_cov_px2;
  const cv::Matx22d to_image = map.jacobian(at).inv();
  const cv::Matx22d seen = to_image * cv::Matx22d(c[0], c[1], c[2], c[3]) * to_image.t();
  return {seen(0, 0), seen(0, 1), seen(1, 0), seen(1, 1)};
}

ordered_json image_json(std::size_t number, const BallImage& image, const reduction::Frame& frame,
                        const Judged& judged, const PlaneMap& map) {
  const cv::Point2d at = map.to_image({image.centre_px.x, image.centre_px.y});
  const double scale = map.image_px_per_plane_px(at);
  const auto scaled = [scale](std::optional<double> plane_px) {
    return plane_px ? ordered_json(*plane_px * scale) : ordered_json();
  };
  const auto leg = judged.leg ? judged.leg : image.leg;
  const auto equator_sd = image.equator_sd_rad ? image.equator_sd_rad : frame.equator_sd_rad;
  const auto diameter_sd = image.diameter_sd_px ? image.diameter_sd_px : frame.diameter_sd_px;
  ordered_json json{{"index", number},
                    {"leg", leg ? ordered_json(name(*leg)) : ordered_json()},
                    {"flash_index", or_null(judged.flash)},
                    {"time_s", or_null(judged.time_s)},
                    {"centre_px", point_json(at)},
                    {"diameter_px", scaled(image.diameter_px)},
                    {"centre_sd_px", scaled(centre_sd(image, frame))},
                    {"diameter_sd_px", scaled(diameter_sd)}};
  json["equator_rad"] = image.equator_rad
                            ? ordered_json(photographed_equator_rad(*image.equator_rad, map, at))
                            : ordered_json();
  json["equator_sd_rad"] = image.equator_rad ? or_null(equator_sd) : ordered_json();
  json["source"] = image.source;
  json["used"] = judged.used;
  json["why_not"] = judged.used ? ordered_json() : ordered_json(judged.why_not);
  json["residual_px"] = scaled(judged.residual_px);
  json["diameter_used"] = judged.diameter_used;
  json["equator_used"] = judged.equator_used;
  json["centre_cov_px2"] = covariance_json(image, map, at);
  return json;
}

constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;

cv::Point2d photographed(const ManualPoint& p, const PlaneMap& map) {
  return p.in_image ? p.point : map.to_image(p.point);
}

ordered_json point_json(const ManualPoint& p, const PlaneMap& map) {
  const cv::Point2d at = photographed(p, map);
  return {at.x, at.y};
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
    json["equator_deg"] = m.equator_in_image
                              ? *m.equator_rad * kDegreesPerRad
                              : photographed_angle_rad(*m.equator_rad, map, at) * kDegreesPerRad;
  if (m.equator_sd_rad) json["equator_sd_deg"] = *m.equator_sd_rad * kDegreesPerRad;
  if (m.no_equator) json["no_equator"] = true;
  if (m.leg) json["leg"] = name(*m.leg);
  if (m.top) json["top_px"] = point_json(*m.top, map);
  put(json, "contact_width_px", m.contact_width_px);
  put(json, "time_s", m.time_s);
}

constexpr std::array<std::string_view, 4> kKinds{"add", "move", "remove", "surface"};  // in the order of Kind

ordered_json correction_json(const Correction& correction, const PlaneMap& map) {
  using Kind = Correction::Kind;
  ordered_json json{{"kind", kKinds[static_cast<std::size_t>(correction.kind)]}};
  if (correction.kind == Kind::surface) {
    json["left_px"] = point_json(correction.surface.left, map);
    json["right_px"] = point_json(correction.surface.right, map);
    put(json, "sd_px", correction.surface.sd_px);
    return json;
  }
  if (correction.kind != Kind::add) json["at_px"] = point_json(correction.at, map);
  const ManualMeasurement& m = correction.measured;
  put_measured(json, m, map, photographed(m.centre ? *m.centre : correction.at, map));
  return json;
}

}  // namespace

ordered_json images_json(const strobe_msgs::shot_t* summary, const strobe_msgs::frame_t& frame,
                         const host::AssemblySettings& settings, const PlaneMap& map) {
  ordered_json images = ordered_json::array();
  const auto read = messages::frame_from_lcm(frame);
  if (!read) return images;
  const std::vector<Judged> judged = judge(summary, frame, *read, settings);
  for (std::size_t i = 0; i < read->images.size(); ++i)
    images.push_back(image_json(i + 1, read->images[i], *read, judged[i], map));
  return images;
}

ordered_json unmeasured_json(std::span<const digitize::Unmeasured> unmeasured, const PlaneMap& map) {
  ordered_json list = ordered_json::array();
  for (const digitize::Unmeasured& each : unmeasured) {
    const cv::Point2d at = map.to_image(each.centre);
    const std::string why(name(each.why.reason));
    list.push_back({{"what", each.what},
                    {"centre_px", point_json(at)},
                    {"diameter_px", each.diameter * map.image_px_per_plane_px(at)},
                    {"why", each.why.detail.empty() ? why : why + ": " + each.why.detail}});
  }
  return list;
}

ordered_json surface_json(const strobe_msgs::frame_t& frame, const PlaneMap& map) {
  if (frame.surface.size() < 2) return nullptr;
  ordered_json line = ordered_json::array();
  for (const auto& p : frame.surface) line.push_back(point_json(map.to_image({p.x_px, p.y_px})));
  return line;
}

ordered_json corrections_json(std::span<const Correction> corrections, const PlaneMap& map) {
  ordered_json list = ordered_json::array();
  for (const Correction& each : corrections) list.push_back(correction_json(each, map));
  return list;
}

}  // namespace strobe::web
