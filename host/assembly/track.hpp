// The path of the ball on a photograph, seen from the surface: what the matching of images to flashes works
// on. Plain values; thread-safe.
#pragma once

#include <vector>

#include "common/reduction/frame.hpp"

namespace strobe::host {

/// An image's centre in the surface's axes. [px of the photograph]
struct TrackPoint {
  reduction::Leg leg = reduction::Leg::contact;
  double along_px = 0.0;  ///< along the surface, positive in the direction of travel
  double up_px = 0.0;     ///< above the surface line
};

struct Track {
  std::vector<TrackPoint> images;  ///< in the frame's order: incoming, contact, rebound
  double radius_px = 0.0;          ///< of the undeformed ball
  double px_per_m = 0.0;
  double sd_px = 0.0;  ///< of each coordinate; stated, or 0.8 % of the diameter if the frame says nothing
  double gravity_along_px = 0.0;  ///< acceleration, px/s^2
  double gravity_up_px = 0.0;     ///< negative
};

}  // namespace strobe::host
