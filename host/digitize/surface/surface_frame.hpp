// The surface's own axes on the photograph: along it and up from it. Plain values; thread-safe.
#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

struct SurfaceFrame {
  cv::Point2d origin;           ///< on the line, plane px
  cv::Point2d along{1.0, 0.0};  ///< unit vector, its x not negative
  double sd_px = 0.0;           ///< of a height above the line

  cv::Point2d up() const { return {-along.y, along.x}; }
  /// (along, up) of a point of the plane.
  cv::Point2d from_plane(cv::Point2d p) const;
  cv::Point2d to_plane(cv::Point2d along_up) const;
};

/// Total least squares through the line's points; at least 2 that differ.
SurfaceFrame surface_frame(const SurfaceLine& line);

}  // namespace strobe::digitize
