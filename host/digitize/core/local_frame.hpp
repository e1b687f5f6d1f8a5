// The plane around one ball as a photograph's pixels see it: axes as in the plane (y up), one unit as large
// as an image pixel there, origin at a point of the plane. The map is followed by a cubic polynomial, so that
// thousands of pixels cost little. Plain values; thread-safe; no allocation.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "host/digitize/core/plane_map.hpp"

namespace strobe::digitize {

class LocalFrame {
 public:
  /// Good within `reach_px` of the centre.
  LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px);

  cv::Point2d from_image(double column, double row) const;
  cv::Point2d to_image(cv::Point2d local_px) const {
    if (plain_) return {centre_image_.x + local_px.x, centre_image_.y - local_px.y};
    const double u = local_px.x / reach_px_, v = local_px.y / reach_px_;
    return {at(column_, u, v), at(row_, u, v)};
  }
  cv::Point2d from_plane(cv::Point2d plane_px) const { return (plane_px - origin_) * scale_; }
  cv::Point2d to_plane(cv::Point2d local_px) const { return origin_ + local_px * (1.0 / scale_); }
  bool is_uncalibrated() const { return plain_; }
  double scale() const { return scale_; }  ///< local px per plane px

 private:
  static constexpr int kTerms = 10;
  using Cubic = std::array<double, kTerms>;
  static double at(const Cubic& cubic, double u, double v);

  bool plain_;
  cv::Point2d centre_image_;
  cv::Point2d origin_;
  double scale_ = 1.0;
  double reach_px_;
  Cubic x_{}, y_{};         ///< local, of the image's offset over the reach
  Cubic column_{}, row_{};  ///< image, of the local offset over the reach
};

}  // namespace strobe::digitize
