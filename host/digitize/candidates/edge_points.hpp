// The places of a photograph where brightness changes most steeply, as points that can vote for what they may
// be the outline of. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace strobe::digitize {

/// A place of steepest brightness, in px of the picture given, with the direction towards the brighter side.
struct EdgePoint {
  cv::Point2f at;
  cv::Point2f normal;  ///< unit vector
};

struct EdgeDetection {
  double neighbourhood_px = 32.0;  ///< over which a gradient is judged: about the ball's radius
  double prominence = 1.8;         ///< over the usual gradient around it
  double floor = 0.0;              ///< light per px: no edge below it
};

/// `light`: CV_32FC1. Ridges of the gradient, thinned to one point across (Canny 1986) and placed by a
/// parabola across. What counts as an edge depends on the gradients around it and not on the brightness, so
/// that faint and bright images vote alike.
std::vector<EdgePoint> find_edge_points(const cv::Mat& light, const EdgeDetection& search);

}  // namespace strobe::digitize
