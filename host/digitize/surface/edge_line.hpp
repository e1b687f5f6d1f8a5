// A straight edge with sub-pixel accuracy: the steepest rise of many profiles across it, and the line that
// they agree on. Deterministic; thread-safe; allocates.
#pragma once

#include <optional>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/surface/hough_lines.hpp"

namespace strobe::digitize {

struct EdgeLine {
  cv::Point2d middle;             ///< plane px, in the middle of what was seen
  double slope = 0.0;             ///< plane px, y up
  double half_span = 0.0;         ///< of x, px
  double visible_fraction = 0.0;  ///< inliers among the profiles that are not occluded
  double visible_px = 0.0;        ///< length
  double rms_px = 0.0;            ///< of the inliers' residuals
  double sd_px = 0.0;             ///< of the height at the middle
  double slope_sd = 0.0;
  double contrast = 0.0;  ///< median rise of intensity

  double at(double x) const { return middle.y + slope * (x - middle.x); }
};

/// Returns nullopt for fewer than 12 inliers.
std::optional<EdgeLine> fit_edge_line(const Photograph& photograph, const PlaneMap& map,
                                      const OcclusionMask& occluded, const HoughLine& start);

}  // namespace strobe::digitize
