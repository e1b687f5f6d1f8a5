// The surface's line on the photograph, from the edge of the plate that every flash lit. Deterministic;
// thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/line.hpp"
#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// Between OpenCV's points and Eigen's vectors, which common/geometry uses.
inline Eigen::Vector2d to_eigen(cv::Point2d p) { return {p.x, p.y}; }
inline cv::Point2d to_point(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

struct SurfaceLine {
  std::vector<cv::Point2d> points;  ///< plane px, left to right, at least 2
  double sd_px =
      0.0;  ///< of each coordinate of a point, seen from the balls: what all of them are off alike is in it
  /// Distance of the front and back edges of a plate seen from above, else 0. The balls' plane cuts the plate
  /// somewhere between: the line lies half-way, and sd_px covers both.
  double edge_separation_px = 0.0;
  /// How far below the edge that is seen the plate's near edge may hide in saturated light, else 0. The line
  /// then lies half-way, too.
  double hidden_px = 0.0;
};

/// The surface's axes on the photograph: along the line and up from it [px]. Horizontal if all points are
/// one.
geometry::SurfaceFrame surface_frame(const SurfaceLine& line);

/// Sd of a height above the line.
double height_sd_px(const SurfaceLine& line);

/// `outlines`: the ball's images, none of which lies below the surface; parts of the line that they cover are
/// not used. Rejections: no_plate, imprecise.
Measured<SurfaceLine> find_surface_line(const Photograph& photograph, const PlaneMap& map,
                                        std::span<const Outline> outlines);

// The image of a ball in contact: flattened below, so that its top and the width of its flat side are
// measured besides its centre. Deterministic; thread-safe; allocates.

struct ContactImage {
  cv::Point2d top;                 ///< farthest point of the ball from the surface
  double top_sd_px = 0.0;          ///< perpendicular to the surface
  std::optional<double> width_px;  ///< of the flat side; absent: not measurable
  std::optional<double> width_sd_px;
};

/// `outline`: fitted to the round part of the image. Rejection: imprecise.
Measured<ContactImage> measure_contact(const Outline& outline, const SurfaceLine& surface);

}  // namespace strobe::digitize
