#include "host/digitize/candidates/edge_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace strobe::digitize {

namespace {

struct Gradient {
  cv::Mat x, y, size;  // CV_32FC1
};

Gradient gradient_of(const cv::Mat& light) {
  Gradient gradient;
  // Scharr's weights keep the direction to a fraction of a degree; the sum of one side is 16.
  cv::Scharr(light, gradient.x, CV_32F, 1, 0, 1.0 / 32.0);
  cv::Scharr(light, gradient.y, CV_32F, 0, 1, 1.0 / 32.0);
  cv::magnitude(gradient.x, gradient.y, gradient.size);
  return gradient;
}

/// The usual size of gradients around each pixel. The mean of roots, so that a few large ones say little.
cv::Mat usual_size(const cv::Mat& size, double neighbourhood_px) {
  cv::Mat root, usual;
  cv::sqrt(size, root);
  const int side = std::clamp(2 * static_cast<int>(neighbourhood_px / 2) + 1, 3, 255);
  cv::boxFilter(root, usual, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_REFLECT);
  return usual.mul(usual);
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

std::vector<EdgePoint> find_edge_points(const cv::Mat& light, const EdgeDetection& search) {
  const Gradient gradient = gradient_of(light);
  const cv::Mat usual = usual_size(gradient.size, search.neighbourhood_px);
  const auto prominence = static_cast<float>(search.prominence);
  const auto floor = static_cast<float>(search.floor);
  const auto stride = static_cast<std::ptrdiff_t>(gradient.size.step1());

  std::vector<EdgePoint> edges;
  for (int y = 1; y + 1 < light.rows; ++y) {
    const auto* size = gradient.size.ptr<float>(y);
    const auto* around = usual.ptr<float>(y);
    const auto* gx = gradient.x.ptr<float>(y);
    const auto* gy = gradient.y.ptr<float>(y);
    for (int x = 1; x + 1 < light.cols; ++x) {
      const float here = size[x];
      if (here <= prominence * around[x] + floor) continue;
      float length = 1.0F;
      const int step = step_towards(gx[x], gy[x], stride, length);
      const float ahead = size[x + step], behind = size[x - step];
      if (here < ahead || here <= behind) continue;
      const float offset = 0.5F * length * (behind - ahead) / (behind - 2 * here + ahead);
      const cv::Point2f normal(gx[x] / here, gy[x] / here);
      edges.push_back({cv::Point2f(static_cast<float>(x), static_cast<float>(y)) + offset * normal, normal});
    }
  }
  return edges;
}

}  // namespace strobe::digitize
