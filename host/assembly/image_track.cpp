#include "host/assembly/image_track.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strobe::host {
namespace {

using reduction::Leg;
using strobe_msgs::ball_image_t;
using strobe_msgs::frame_t;

constexpr double kGravity_mps2 = 9.81;
// A person who marks a centre by hand errs by about 0.5 mm, 0.8 % of a ball's diameter.
constexpr double kHandSdOfDiameter = 0.008;
// Centres this much of a radius lower than one radius belong to a ball that touches, noise apart.
constexpr double kTouchingOfRadius = 0.05;

struct Line {
  double x0 = 0.0, y0 = 0.0, cosine = 1.0, sine = 0.0;
};

/// Total least squares through the surface points.
std::optional<Line> surface_line(const frame_t& frame) {
  if (frame.surface.size() < 2) return std::nullopt;
  Line line;
  const auto n = static_cast<double>(frame.surface.size());
  for (const auto& p : frame.surface) {
    line.x0 += p.x_px / n;
    line.y0 += p.y_px / n;
  }
  double sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (const auto& p : frame.surface) {
    sxx += (p.x_px - line.x0) * (p.x_px - line.x0);
    sxy += (p.x_px - line.x0) * (p.y_px - line.y0);
    syy += (p.y_px - line.y0) * (p.y_px - line.y0);
  }
  const double angle = 0.5 * std::atan2(2.0 * sxy, sxx - syy);
  if (!std::isfinite(angle) || sxx + syy <= 0.0) return std::nullopt;
  line.cosine = std::cos(angle);
  line.sine = std::sin(angle);
  return line;
}

bool has_diameter(const ball_image_t& image) {
  return std::isfinite(image.diameter_px) && image.diameter_px > 0.0;
}

bool usable(const ball_image_t& image) {
  return std::isfinite(image.centre_x_px) && std::isfinite(image.centre_y_px) &&
         (has_diameter(image) || image.leg == ball_image_t::LEG_CONTACT);
}

/// Median diameter, of the images that nobody saw in contact if there are any: contact flattens the ball.
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

/// Of each coordinate of a centre, as stated: the images' own covariances (root mean square of those in the
/// air), else the frame's.
std::optional<double> stated_sd_px(const frame_t& frame) {
  double sum = 0.0;
  int count = 0;
  for (const ball_image_t& image : frame.images) {
    const double variance = 0.5 * (image.centre_xx_px2 + image.centre_yy_px2);
    if (image.leg == ball_image_t::LEG_CONTACT || !std::isfinite(variance) || !(variance > 0.0)) continue;
    sum += variance;
    ++count;
  }
  if (count > 0) return std::sqrt(sum / count);
  if (std::isfinite(frame.centre_sd_px) && frame.centre_sd_px > 0.0) return frame.centre_sd_px;
  return std::nullopt;
}

double distance_to_line(const TrackPoint& p, const TrackPoint& a, const TrackPoint& b) {
  const double dx = b.along_px - a.along_px;
  const double dy = b.up_px - a.up_px;
  const double length = std::hypot(dx, dy);
  if (length <= 0.0) return std::hypot(p.along_px - a.along_px, p.up_px - a.up_px);
  return std::abs((p.along_px - a.along_px) * dy - (p.up_px - a.up_px) * dx) / length;
}

/// Whether the lowest image, which does not touch, comes before the impact: it lies on the line of its own
/// leg.
bool lowest_is_incoming(const std::vector<TrackPoint>& images, std::size_t lowest) {
  const bool two_before = lowest >= 2;
  const bool two_after = lowest + 2 < images.size();
  if (two_before != two_after) return two_before;
  if (!two_before) return lowest > 0 || images.size() == 1;
  return distance_to_line(images[lowest], images[lowest - 1], images[lowest - 2]) <=
         distance_to_line(images[lowest], images[lowest + 1], images[lowest + 2]);
}

void find_legs(const frame_t& frame, Track& track) {
  std::vector<TrackPoint>& images = track.images;
  if (images.empty()) return;
  const auto low =
      std::min_element(images.begin(), images.end(),
                       [](const TrackPoint& a, const TrackPoint& b) { return a.up_px < b.up_px; });
  const auto lowest = static_cast<std::size_t>(low - images.begin());
  const double touching = track.radius_px - std::max(3.0 * track.sd_px, kTouchingOfRadius * track.radius_px);
  const bool lowest_before = lowest_is_incoming(images, lowest);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto named = frame.images[i].leg;
    if (named == ball_image_t::LEG_CONTACT || images[i].up_px < touching) {
      images[i].leg = Leg::contact;
    } else if (named == ball_image_t::LEG_INCOMING) {
      images[i].leg = Leg::incoming;
    } else if (named == ball_image_t::LEG_REBOUND) {
      images[i].leg = Leg::rebound;
    } else {
      images[i].leg = i < lowest || (i == lowest && lowest_before) ? Leg::incoming : Leg::rebound;
    }
  }
}

/// Legs must follow each other; one image named out of order would break the matching of all others.
void mend_order(std::vector<TrackPoint>& images) {
  std::size_t first_rebound = images.size();
  while (first_rebound > 0 && images[first_rebound - 1].leg == Leg::rebound) --first_rebound;
  std::size_t last_incoming = 0;
  while (last_incoming < images.size() && images[last_incoming].leg == Leg::incoming) ++last_incoming;
  for (std::size_t i = last_incoming; i < first_rebound; ++i) images[i].leg = Leg::contact;
}

}  // namespace

std::optional<Track> image_track(const frame_t& frame, double ball_diameter_m, double surface_angle_deg) {
  const auto line = surface_line(frame);
  const auto diameter = ball_diameter_px(frame);
  if (!line || !diameter || !std::all_of(frame.images.begin(), frame.images.end(), usable))
    return std::nullopt;
  Track track;
  track.radius_px = 0.5 * *diameter;
  track.px_per_m = *diameter / ball_diameter_m;
  track.sd_px = stated_sd_px(frame).value_or(kHandSdOfDiameter * *diameter);
  for (const ball_image_t& image : frame.images) {
    const double dx = image.centre_x_px - line->x0;
    const double dy = image.centre_y_px - line->y0;
    track.images.push_back(
        {Leg::contact, dx * line->cosine + dy * line->sine, dy * line->cosine - dx * line->sine});
  }
  const bool leftwards =
      !track.images.empty() && track.images.back().along_px < track.images.front().along_px;
  const double towards = leftwards ? -1.0 : 1.0;
  for (TrackPoint& image : track.images) image.along_px *= towards;
  const double slope = surface_angle_deg * std::numbers::pi / 180.0;
  track.gravity_along_px = -towards * kGravity_mps2 * std::sin(slope) * track.px_per_m;
  track.gravity_up_px = -kGravity_mps2 * std::cos(slope) * track.px_per_m;
  find_legs(frame, track);
  mend_order(track.images);
  return track;
}

}  // namespace strobe::host
