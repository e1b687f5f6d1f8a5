#include "host/assembly/image_track.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/flight/parabola.hpp"
#include "common/geometry/leg_classification.hpp"
#include "common/geometry/surface_frame.hpp"
#include "common/units/angles.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::ball_image_t;
using strobe_msgs::frame_t;

// The digitizer misses three airborne images in 36,921 (host/digitize/README.md); of images in contact, which are fewer, no more
// is known than that they are found nearly as well.
constexpr double kMissedByDigitizer = 0.001;
// Centres this much of a radius lower than one radius belong to a ball that touches, noise apart.
constexpr double kTouchingOfRadius = 0.05;

std::optional<geometry::Line> surface_line(const frame_t& frame) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& p : frame.surface) points.emplace_back(p.x_px, p.y_px);
  return geometry::fit_line(points);
}

bool has_diameter(const ball_image_t& image) {
  return std::isfinite(image.diameter_px) && image.diameter_px > 0.0;
}

bool usable(const ball_image_t& image) {
  return std::isfinite(image.centre_x_px) && std::isfinite(image.centre_y_px) &&
         (has_diameter(image) || image.leg == ball_image_t::LEG_CONTACT);
}

/// Median diameter of the images that are not labelled contact, if there are any: contact flattens the ball.
std::optional<double> ball_diameter_px(const frame_t& frame) {
  std::vector<double> diameters;
  for (const bool all : {false, true}) {
    for (const ball_image_t& image : frame.images) {
      if (has_diameter(image) && (all || image.leg != ball_image_t::LEG_CONTACT))
        diameters.push_back(image.diameter_px);
    }
    if (!diameters.empty()) break;
  }
  if (diameters.empty()) return std::nullopt;
  const auto middle = diameters.begin() + static_cast<std::ptrdiff_t>(diameters.size() / 2);
  std::nth_element(diameters.begin(), middle, diameters.end());
  return *middle;
}

/// Of each coordinate of a centre; NaN or less: not stated.
double own_variance(const ball_image_t& image) { return 0.5 * (image.centre_xx_px2 + image.centre_yy_px2); }

/// Of each coordinate of a centre, as stated: the images' own covariances (root mean square of those in the
/// air), else the frame's.
std::optional<double> stated_sd_px(const frame_t& frame) {
  double sum = 0.0;
  int count = 0;
  for (const ball_image_t& image : frame.images) {
    const double variance = own_variance(image);
    if (image.leg == ball_image_t::LEG_CONTACT || !std::isfinite(variance) || !(variance > 0.0)) continue;
    sum += variance;
    ++count;
  }
  if (count > 0) return std::sqrt(sum / count);
  if (std::isfinite(frame.centre_sd_px) && frame.centre_sd_px > 0.0) return frame.centre_sd_px;
  return std::nullopt;
}

std::optional<Leg> label(const ball_image_t& image) {
  if (image.leg == ball_image_t::LEG_INCOMING) return Leg::incoming;
  if (image.leg == ball_image_t::LEG_CONTACT) return Leg::contact;
  if (image.leg == ball_image_t::LEG_REBOUND) return Leg::rebound;
  return std::nullopt;
}

}  // namespace

std::optional<matching::Track> image_track(const frame_t& frame, double ball_diameter_m,
                                           double surface_angle_deg) {
  const auto line = surface_line(frame);
  const auto diameter = ball_diameter_px(frame);
  if (!line || !diameter || !std::all_of(frame.images.begin(), frame.images.end(), usable))
    return std::nullopt;
  matching::Track track;
  track.radius_px = 0.5 * *diameter;
  track.px_per_m = *diameter / ball_diameter_m;
  if (frame.source == "auto") track.missed_share = kMissedByDigitizer;
  track.sd_px = stated_sd_px(frame).value_or(kHandSdOfDiameter * *diameter);
  geometry::SurfaceFrame surface{.line = *line};
  const auto place = [&](const ball_image_t& image) {
    return surface.from_image({image.centre_x_px, image.centre_y_px});
  };
  surface.mirrored =
      !frame.images.empty() && place(frame.images.back()).x() < place(frame.images.front()).x();
  std::vector<Eigen::Vector2d> centres;
  std::vector<std::optional<Leg>> labels;
  for (const ball_image_t& image : frame.images) {
    centres.push_back(place(image));
    labels.push_back(label(image));
  }
  const double contact_height =
      track.radius_px - std::max(3.0 * track.sd_px, kTouchingOfRadius * track.radius_px);
  const std::vector<Leg> legs = geometry::classify_untimed(centres, labels, contact_height);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const double share = own_variance(frame.images[i]) / (track.sd_px * track.sd_px);
    track.images.push_back({legs[i], centres[i], std::isfinite(share) && share > 0.0 ? share : 1.0});
  }
  track.gravity_pxps2 = flight::gravity_mps2(radians(surface_angle_deg)) * track.px_per_m;
  if (surface.mirrored) track.gravity_pxps2.x() *= -1.0;
  return track;
}

}  // namespace strobe::host
