// Edge points: where intensity changes most steeply. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace strobe::digitize {

/// In px of the picture.
struct EdgePoint {
  cv::Point2f at;
  cv::Point2f normal;  ///< unit vector towards the brighter side
};

struct EdgeDetection {
  double neighbourhood_px = 32.0;  ///< of the local threshold: about the ball's radius
  double prominence = 1.8;         ///< threshold over the typical gradient around
  double floor = 0.0;              ///< least gradient, intensity per px
};

/// `intensity`: CV_32FC1. Local maxima of the gradient along its direction (Canny 1986), with sub-pixel
/// positions by a parabola. The threshold follows the gradients around and not the brightness, so that faint
/// and bright images count alike.
std::vector<EdgePoint> find_edge_points(const cv::Mat& intensity, const EdgeDetection& detection);

}  // namespace strobe::digitize
