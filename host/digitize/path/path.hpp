// Which round things are one ball on its way to the surface and off it: two nearly straight legs that meet
// there, with images in contact between them; or one leg alone, as in free flight. Geometry only: no
// photograph. Deterministic; thread-safe; allocates.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

namespace strobe::digitize {

/// A round thing, in axes with y up: along and up from the surface where it is known, else the photograph's.
struct PathPoint {
  cv::Point2d at;
  double sd_px = 0.0;   ///< of each coordinate
  double weight = 1.0;  ///< how surely it is a ball, 0 to 1
};

struct PathContext {
  double diameter_px = 0.0;
  bool surface_known = false;  ///< then y = 0 is the surface
  double surface_sd_px = 0.0;
};

/// Indices into the points.
struct Path {
  /// Airborne, from far to the surface; the second is empty where there is one leg. Which of them comes first
  /// in time is not said here.
  std::array<std::vector<int>, 2> legs;
  std::vector<int> contact;  ///< by x
  struct Left {
    int index = 0;
    bool below = false;   ///< it lies below the surface
    double off_px = 0.0;  ///< distance to the nearest leg's line
  };
  std::vector<Left> left;  ///< what belongs to none

  bool bounces() const { return !legs[0].empty() && !legs[1].empty(); }
};

Path find_path(std::span<const PathPoint> points, const PathContext& scene);

/// Whether a centre at that height belongs to a ball that touches the surface.
bool touches(double height_px, double sd_px, const PathContext& scene);

}  // namespace strobe::digitize
