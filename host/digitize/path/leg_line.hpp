// A leg of flight on the photograph: a straight line, slightly bent by gravity. Plain values; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
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
  /// Of offset (px), slope and bend (1/px) at the origin; zero for a line that is only looked along.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// Along the line from the origin, and distance from the leg, positive to its left.
  double place(cv::Point2d p) const { return (p - origin).dot(along); }
  double off(cv::Point2d p) const;
  /// The leg's own sd there, across it.
  double sd(cv::Point2d p) const;
};

/// Through points[members], at least 2 at different places; bent from 4 on.
LegLine fit_leg_line(std::span<const PathPoint> points, std::vector<int> members, double diameter_px);

/// Largest distance of an inlier from its leg, whose own sd there is `leg_sd_px`.
double leg_tolerance(const PathPoint& point, double diameter_px, double leg_sd_px = 0.0);

/// Every leg with two or more inliers among `eligible`, most inliers by weight first, at most `max_lines`.
std::vector<LegLine> leg_lines(std::span<const PathPoint> points, std::span<const int> eligible,
                               double diameter_px, std::size_t max_lines);

}  // namespace strobe::digitize
