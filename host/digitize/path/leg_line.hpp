// A leg of flight on the photograph: a straight line, slightly bent by gravity. Plain values; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

struct LegLine {
  cv::Point2d origin;
  cv::Point2d along{1.0, 0.0};  ///< unit vector
  double bend_per_px = 0.0;     ///< distance from the straight line = bend·place²
  std::vector<int> members;     ///< ascending
  double weight = 0.0;          ///< sum of the members'

  /// Along the line from the origin, and distance from the leg, positive to its left.
  double place(cv::Point2d p) const { return (p - origin).dot(along); }
  double off(cv::Point2d p) const;
};

/// Through points[members], at least 2 at different places; bent from 4 on.
LegLine fit_leg_line(std::span<const PathPoint> points, std::vector<int> members, double diameter_px);

/// Largest distance of an inlier from its leg.
double leg_tolerance(const PathPoint& point, double diameter_px);

/// Every leg with two or more inliers among `eligible`, most inliers by weight first, at most `max_lines`.
std::vector<LegLine> leg_lines(std::span<const PathPoint> points, std::span<const int> eligible,
                               double diameter_px, std::size_t max_lines);

}  // namespace strobe::digitize
