#include "host/digitize/candidates/edge_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace strobe::digitize {

namespace {

struct Gradient {
  cv::Mat x, y, magnitude;  // CV_32FC1
};

Gradient gradient_of(const cv::Mat& intensity) {
  Gradient gradient;
  // Scharr's weights preserve the direction to a fraction of a degree; those of one side sum to 16.
  cv::Scharr(intensity, gradient.x, CV_32F, 1, 0, 1.0 / 32.0);
  cv::Scharr(intensity, gradient.y, CV_32F, 0, 1, 1.0 / 32.0);
  cv::magnitude(gradient.x, gradient.y, gradient.magnitude);
  return gradient;
}

/// Typical gradient around each pixel: the squared mean of roots, so that a few large ones count little.
cv::Mat typical_magnitude(const cv::Mat& magnitude, double neighbourhood_px) {
  cv::Mat root, typical;
  cv::sqrt(magnitude, root);
  const int side = std::clamp(2 * static_cast<int>(neighbourhood_px / 2) + 1, 3, 255);
  cv::boxFilter(root, typical, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_REFLECT);
  return typical.mul(typical);
}

/// Of the eight directions to a neighbour, the one nearest to (gx, gy).
int step_towards(float gx, float gy, std::ptrdiff_t stride, float& length) {
  constexpr float kTangent = 0.41421356F;  // of 22.5 degrees
  const float ax = std::abs(gx), ay = std::abs(gy);
  const int sx = gx > 0 ? 1 : -1, sy = gy > 0 ? 1 : -1;
  const int row = static_cast<int>(stride);
  length = 1.0F;
  if (ay < kTangent * ax) return sx;
  if (ax < kTangent * ay) return sy * row;
  length = 1.41421356F;
  return sy * row + sx;
}

}  // namespace

std::vector<EdgePoint> find_edge_points(const cv::Mat& intensity, const EdgeDetection& detection) {
  const Gradient gradient = gradient_of(intensity);
  const cv::Mat typical = typical_magnitude(gradient.magnitude, detection.neighbourhood_px);
  const auto prominence = static_cast<float>(detection.prominence);
  const auto floor = static_cast<float>(detection.floor);
  const auto stride = static_cast<std::ptrdiff_t>(gradient.magnitude.step1());

  std::vector<EdgePoint> edges;
  for (int y = 1; y + 1 < intensity.rows; ++y) {
    const auto* magnitude = gradient.magnitude.ptr<float>(y);
    const auto* around = typical.ptr<float>(y);
    const auto* gx = gradient.x.ptr<float>(y);
    const auto* gy = gradient.y.ptr<float>(y);
    for (int x = 1; x + 1 < intensity.cols; ++x) {
      const float here = magnitude[x];
      if (here <= prominence * around[x] + floor) continue;
      float length = 1.0F;
      const int step = step_towards(gx[x], gy[x], stride, length);
      const float ahead = magnitude[x + step], behind = magnitude[x - step];
      if (here < ahead || here <= behind) continue;
      const float offset = 0.5F * length * (behind - ahead) / (behind - 2 * here + ahead);
      const cv::Point2f normal(gx[x] / here, gy[x] / here);
      edges.push_back({cv::Point2f(static_cast<float>(x), static_cast<float>(y)) + offset * normal, normal});
    }
  }
  return edges;
}

}  // namespace strobe::digitize
