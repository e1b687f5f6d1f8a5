// Maps between a photograph and the plane in which the balls fly, as a camera square to it would see it
// ("plane px": x to the right, y up, one scale everywhere; the coordinates of frames). Plain values;
// thread-safe; no allocation.
//
// Without a calibration x = column and y = height - 1 - row. With one (host/camera) the lens distortion is
// removed first, then the homography's tilt.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

namespace strobe::digitize {

/// Radial and tangential distortion as in OpenCV: with (u, v) = (image - centre)/focal_px undistorted and r
/// its length, distorted = (u, v)·(1 + k1 r² + k2 r⁴) + tangential(p1, p2).
struct LensDistortion {
  cv::Point2d centre_px;  ///< image px
  double focal_px = 1.0;  ///< the unit of the polynomial's argument
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
};

/// Where the lens is, seen from the plane. A ball's outline is an ellipse from there.
struct Viewpoint {
  cv::Point2d foot_px;       ///< of the perpendicular from the lens to the plane, plane px
  double distance_px = 0.0;  ///< lens to plane, > 0
};

/// An ellipse in plane px.
struct EllipsePx {
  cv::Point2d centre;
  double along = 0.0;  ///< semi-axis in the direction axis_rad
  double across = 0.0;
  double axis_rad = 0.0;  ///< counter-clockwise from +x
};

class PlaneMap {
 public:
  /// x = column, y = height_px - 1 - row.
  static PlaneMap uncalibrated(int height_px);
  /// rectify: homography from undistorted image px (column, row) to plane px.
  static PlaneMap calibrated(const LensDistortion& lens, const cv::Matx33d& rectify,
                             const std::optional<Viewpoint>& viewpoint);

  /// The same plane, seen on the photograph made larger by that factor, as enlarged() does.
  PlaneMap on_enlarged(double factor) const;

  cv::Point2d to_plane(cv::Point2d image_px) const;
  cv::Point2d to_image(cv::Point2d plane_px) const;
  /// d(plane)/d(image).
  cv::Matx22d jacobian(cv::Point2d image_px) const;
  /// Linear scale of the photograph there, from the ratio of areas.
  double image_px_per_plane_px(cv::Point2d image_px) const;
  /// Whether plane px are the photograph's own, with y turned upwards.
  bool is_uncalibrated() const { return uncalibrated_ && enlarged_ == 1.0; }

  /// The outline of a ball with its centre in the plane at `centre_px`: a sphere's perspective image where
  /// the viewpoint is known, else a circle.
  EllipsePx outline(cv::Point2d centre_px, double diameter_px) const;
  const std::optional<Viewpoint>& viewpoint() const { return viewpoint_; }

 private:
  cv::Point2d own(cv::Point2d enlarged_px) const;
  cv::Point2d own_to_plane(cv::Point2d image_px) const;
  cv::Point2d plane_to_own(cv::Point2d plane_px) const;
  cv::Matx22d own_jacobian(cv::Point2d image_px) const;

  bool uncalibrated_ = true;
  double enlarged_ = 1.0;
  double height_px_ = 0.0;
  LensDistortion lens_;
  cv::Matx33d rectify_ = cv::Matx33d::eye();
  cv::Matx33d unrectify_ = cv::Matx33d::eye();
  std::optional<Viewpoint> viewpoint_;
};

}  // namespace strobe::digitize
