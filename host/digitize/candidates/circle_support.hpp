// Edge points in support of a circle, and the circle that fits them. Deterministic; a CircleSupport may be
// read by many threads and claimed from by one; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "host/digitize/candidates/edge_points.hpp"

namespace strobe::digitize {

struct Circle {
  cv::Point2d centre;
  double radius = 0.0;
};

struct SupportedCircle {
  Circle circle;
  double coverage = 0.0;  ///< fraction of the circle with edge points, isolated ones not counted
};

/// Edge points in square cells, so that those near a circle are found without visiting all.
class CircleSupport {
 public:
  CircleSupport(const std::vector<EdgePoint>& edges, cv::Size size);

  /// Least squares of centre and radius to unclaimed edge points with normals along the radius, from `start`,
  /// within a band that narrows. The radius stays within the bounds.
  SupportedCircle fit(const Circle& start, double radius_min, double radius_max) const;

  /// Removes the circle's edge points from later fits.
  void claim(const Circle& circle);

  /// Gives all that was claimed back.
  void release();

 private:
  template <typename Visit>
  void visit_ring(const Circle& circle, double band, Visit visit) const;

  std::vector<EdgePoint> edges_;      // by cell
  std::vector<std::uint32_t> first_;  // of each cell; one more at the end
  std::vector<unsigned char> claimed_;
  int columns_ = 0, rows_ = 0;
};

}  // namespace strobe::digitize
