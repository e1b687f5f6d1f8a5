// Which edges lie on a circle, and the circle that fits them. Deterministic; a CircleSupport may be read by
// many threads, claimed from by one; allocates.
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
  double share = 0.0;      ///< of the turn where edges lie on it in stretches
  double deviation = 0.0;  ///< rms of those edges from it
};

/// Edges sorted into square cells, so that those near a circle are found without looking at all.
class CircleSupport {
 public:
  CircleSupport(std::vector<EdgePoint> edges, cv::Size size);

  /// Fits centre and radius to edges that point inwards along the radius, starting from `start`, by least
  /// squares over a band that narrows; the radius stays within the bounds. Claimed edges are left out.
  SupportedCircle fit(const Circle& start, double radius_min, double radius_max) const;

  /// The edges on the circle are its own from now on.
  void claim(const Circle& circle);

 private:
  template <typename Visit>
  void visit_ring(const Circle& circle, double band, Visit visit) const;

  std::vector<EdgePoint> edges_;      // by cell
  std::vector<std::uint32_t> first_;  // of each cell; one more at the end
  std::vector<unsigned char> claimed_;
  int columns_ = 0, rows_ = 0;
};

}  // namespace strobe::digitize
