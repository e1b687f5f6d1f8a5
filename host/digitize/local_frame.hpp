// The plane around one ball as a photograph's pixels see it: axes as in the plane (y up), one unit as large
// as an image pixel there, origin at a point of the plane. The map is followed by a cubic polynomial, so that
// thousands of pixels cost little. Plain values; thread-safe; no allocation.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "host/digitize/plane_map.hpp"

namespace strobe::digitize {

class LocalFrame {
 public:
  /// Good within `reach_px` of the centre.
  LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px);

  cv::Point2d from_image(double column, double row) const;
  /// Good to some hundredths of the distance from the centre.
  cv::Point2d to_image(cv::Point2d local_px) const;
  cv::Point2d from_plane(cv::Point2d plane_px) const { return (plane_px - origin_) * scale_; }
  cv::Point2d to_plane(cv::Point2d local_px) const { return origin_ + local_px * (1.0 / scale_); }
  bool is_plain() const { return plain_; }
  double scale() const { return scale_; }  ///< local px per plane px

 private:
  static constexpr int kTerms = 10;
  bool plain_;
  cv::Point2d centre_image_;
  cv::Point2d origin_;
  double scale_ = 1.0;
  cv::Matx22d to_image_{1.0, 0.0, 0.0, -1.0};
  double reach_px_;
  std::array<double, kTerms> x_{}, y_{};
};

}  // namespace strobe::digitize
