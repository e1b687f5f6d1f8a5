#include "common/reduction/matching/track.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/flight/parabola.hpp"
#include "common/geometry/leg_classification.hpp"
#include "common/geometry/line.hpp"
#include "common/units/angles.hpp"

namespace strobe::matching {
namespace {

using reduction::BallImage;
using reduction::Frame;

// Centres this much of a radius lower than one radius belong to a ball that touches, noise apart.
constexpr double kTouchingOfRadius = 0.05;

std::optional<geometry::Line> surface_line(const Frame& frame) {
  std::vector<Eigen::Vector2d> points;
  for (const reduction::PointPx& p : frame.surface_px) points.emplace_back(p.x, p.y);
  return geometry::fit_line(points);
}

/// Median diameter of the images that are not labelled contact, if there are any: contact flattens the ball.
std::optional<double> ball_diameter_px(const Frame& frame) {
  std::vector<double> diameters;
  for (const bool all : {false, true}) {
    for (const BallImage& image : frame.images) {
      if (image.diameter_px > 0.0 && (all || image.leg != Leg::contact))
        diameters.push_back(image.diameter_px);
    }
    if (!diameters.empty()) break;
  }
  if (diameters.empty()) return std::nullopt;
  const auto middle = diameters.begin() + static_cast<std::ptrdiff_t>(diameters.size() / 2);
  std::nth_element(diameters.begin(), middle, diameters.end());
  return *middle;
}

/// Of each coordinate of a centre.
std::optional<double> own_variance(const BallImage& image) {
  if (!image.centre_cov_px2) return std::nullopt;
  const auto& covariance = *image.centre_cov_px2;
  return 0.5 * (covariance[0] + covariance[3]);
}

/// Of each coordinate of a centre, as stated: the images' own covariances (root mean square of those in the
/// air), else the frame's.
std::optional<double> stated_sd_px(const Frame& frame) {
  double sum = 0.0;
  int count = 0;
  for (const BallImage& image : frame.images) {
    const auto variance = own_variance(image);
    if (image.leg == Leg::contact || !variance) continue;
    sum += *variance;
    ++count;
  }
  return count > 0 ? std::optional(std::sqrt(sum / count)) : frame.centre_sd_px;
}

}  // namespace

bool allow_for_drop(Track& track) {
  // A leg gathers its images in a band of so many diameters; tilted by a tenth it leaves that within two of
  // them.
  constexpr double kWidthOfDiameter = 0.25;
  constexpr double kShareHidden = 0.3;
  constexpr int kMaxHidden = 8;
  double left = std::numeric_limits<double>::infinity(), right = -left;
  double lowest[2] = {left, left}, highest[2] = {right, right};
  for (const TrackPoint& image : track.images) {
    if (image.leg == Leg::contact) continue;
    const std::size_t leg = image.leg == Leg::rebound ? 1 : 0;
    left = std::min(left, image.centre_px.x());
    right = std::max(right, image.centre_px.x());
    lowest[leg] = std::min(lowest[leg], image.centre_px.y());
    highest[leg] = std::max(highest[leg], image.centre_px.y());
  }
  const double common = std::min(highest[0], highest[1]) - std::max(lowest[0], lowest[1]);
  if (!(common > 0.0 && right - left <= kWidthOfDiameter * 2.0 * track.radius_px)) return false;
  track.missed_share = std::max(track.missed_share, kShareHidden);
  track.most_missed = kMaxHidden;
  return true;
}

std::optional<Track> image_track(const Frame& frame) {
  const auto line = surface_line(frame);
  const auto diameter = ball_diameter_px(frame);
  if (!line || !diameter) return std::nullopt;
  Track track;
  track.radius_px = 0.5 * *diameter;
  track.px_per_m = *diameter / frame.ball_diameter_m;
  track.sd_px = stated_sd_px(frame).value_or(kHandSdOfDiameter * *diameter);
  geometry::SurfaceFrame surface{.line = *line};
  const auto place = [&](const BallImage& image) {
    return surface.from_image({image.centre_px.x, image.centre_px.y});
  };
  surface.mirrored = place(frame.images.back()).x() < place(frame.images.front()).x();
  std::vector<Eigen::Vector2d> centres;
  std::vector<std::optional<Leg>> labels;
  for (const BallImage& image : frame.images) {
    centres.push_back(place(image));
    labels.push_back(image.leg);
  }
  const double contact_height =
      track.radius_px - std::max(3.0 * track.sd_px, kTouchingOfRadius * track.radius_px);
  const std::vector<Leg> legs = geometry::classify_untimed(centres, labels, contact_height);
  assert(legs.size() == frame.images.size());
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const double share = own_variance(frame.images[i]).value_or(0.0) / (track.sd_px * track.sd_px);
    track.images.push_back({legs[i], centres[i], std::isfinite(share) && share > 0.0 ? share : 1.0,
                            frame.images[i].probability.value_or(1.0)});
  }
  track.gravity_pxps2 = flight::gravity_mps2(radians(frame.surface_angle_deg)) * track.px_per_m;
  if (surface.mirrored) track.gravity_pxps2.x() *= -1.0;
  return track;
}

}  // namespace strobe::matching
