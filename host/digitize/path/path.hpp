// The path of the ball through its images: two nearly straight legs that meet at the surface, with images in
// contact between them; one leg alone, as in free flight; or curved legs of free flight, joined by any number of
// bounces. Geometry only, no photograph. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/types.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

/// An outline's centre, in axes with y up: along and up from the surface if it is known, else the plane's.
struct PathPoint {
  cv::Point2d at;
  double sd_px = 0.0;   ///< of each coordinate
  double weight = 1.0;  ///< probability-like confidence that it is a ball, 0 to 1
};

struct PathContext {
  double diameter_px = 0.0;
  bool surface_known = false;  ///< then y = 0 is the surface
  double surface_sd_px = 0.0;
};

std::vector<PathPoint> path_points(std::span<const Outline> outlines,
                                   const std::optional<SurfaceLine>& surface);

/// With the outlines' median diameter.
PathContext path_context(std::span<const Outline> outlines, const std::optional<SurfaceLine>& surface);

/// Indices into the points.
struct Path {
  /// In the air: one leg after the other, and the images of each, along the path from one of its ends. Which end
  /// comes first in time is not decided here. A leg alone begins far from the surface. None is empty.
  std::vector<std::vector<int>> legs;
  std::vector<int> contact;  ///< by x
  bool curved = false;       ///< legs bend as gravity has it, from left to right
  struct Outlier {
    int index = 0;
    bool below = false;   ///< below the surface
    double off_px = 0.0;  ///< distance to the nearest leg, infinite without a leg
  };
  std::vector<Outlier> outliers;

  bool bounces() const { return legs.size() >= 2; }
};

/// Whether each of the points is in exactly one list: what find_path() guarantees.
bool is_partition(const Path& path, std::size_t points);

Path find_path(std::span<const PathPoint> points, const PathContext& context);

/// Whether a ball with its centre at that height touches the surface.
bool touches(double height_px, double sd_px, const PathContext& context);

}  // namespace strobe::digitize
