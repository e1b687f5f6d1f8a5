// The path of the ball on a photograph, seen from the surface: what the matching of images to flashes works
// on. Plain values; thread-safe.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/flight/aerodynamics.hpp"
#include "common/shot/leg.hpp"

namespace strobe::matching {

struct TrackPoint {
  Leg leg = Leg::contact;
  /// In the surface's axes: along it in the direction of travel, up from it. [px of the photograph]
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double variance_share = 1.0;  ///< variance of each coordinate over Track::sd_px squared; > 0
};

struct Track {
  std::vector<TrackPoint> images;  ///< in the frame's order: incoming, contact, rebound
  double radius_px = 0.0;          ///< of the undeformed ball
  bool surface_known = true;       ///< else nothing is known of where the legs end, nor of the contact
  double px_per_m = 0.0;
  double sd_px = 0.0;  ///< of each coordinate; as stated, else 0.8 % of the diameter
  Eigen::Vector2d gravity_pxps2 = Eigen::Vector2d::Zero();
  flight::Aerodynamics air{.drag_per_m = 0.0, .lift_per_m = 0.0};  ///< of the ball
  double missed_share = 0.005;  ///< of the ball's images that are not found
  double time_sd_s = 0.0;       ///< of a flash's time
};

}  // namespace strobe::matching
