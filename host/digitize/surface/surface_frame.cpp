#include "host/digitize/surface/surface_frame.hpp"

#include <cmath>

namespace strobe::digitize {

cv::Point2d SurfaceFrame::from_plane(cv::Point2d p) const {
  const cv::Point2d d = p - origin;
  return {d.dot(along), d.dot(up())};
}

cv::Point2d SurfaceFrame::to_plane(cv::Point2d p) const { return origin + p.x * along + p.y * up(); }

SurfaceFrame surface_frame(const SurfaceLine& line) {
  SurfaceFrame frame;
  const auto n = static_cast<double>(line.points.size());
  for (const cv::Point2d& p : line.points) frame.origin += p / n;
  double sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (const cv::Point2d& p : line.points) {
    const cv::Point2d d = p - frame.origin;
    sxx += d.x * d.x;
    sxy += d.x * d.y;
    syy += d.y * d.y;
  }
  const double angle = 0.5 * std::atan2(2.0 * sxy, sxx - syy);  // within a quarter turn of +x
  frame.along = {std::cos(angle), std::sin(angle)};
  frame.sd_px = line.sd_px / std::sqrt(std::max(1.0, n - 1.0));
  return frame;
}

}  // namespace strobe::digitize
