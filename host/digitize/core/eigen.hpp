// Between OpenCV's points and Eigen's vectors, which common/geometry uses.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace strobe::digitize {

inline Eigen::Vector2d to_eigen(cv::Point2d p) { return {p.x, p.y}; }
inline cv::Point2d to_point(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

}  // namespace strobe::digitize
