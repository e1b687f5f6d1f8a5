#include "host/digitize/core/plane_map.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::digitize {
namespace {

/// A point and how it moves with its argument.
struct Moved {
  cv::Point2d at;
  cv::Matx22d derivative;
};

/// Distortion in units of the focal length (OpenCV's polynomial: Brown 1966, Conrady 1919).
Moved distort(const LensDistortion& lens, cv::Point2d p) {
  const double xx = p.x * p.x, yy = p.y * p.y, xy = p.x * p.y;
  const double r2 = xx + yy;
  const double radial = 1.0 + r2 * (lens.k1 + r2 * lens.k2);
  const double slope = 2.0 * (lens.k1 + 2.0 * r2 * lens.k2);  // d(radial)/d(r²), twice
  Moved moved;
  moved.at = {p.x * radial + 2.0 * lens.p1 * xy + lens.p2 * (r2 + 2.0 * xx),
              p.y * radial + lens.p1 * (r2 + 2.0 * yy) + 2.0 * lens.p2 * xy};
  const double across = slope * xy + 2.0 * (lens.p1 * p.x + lens.p2 * p.y);
  moved.derivative = {radial + slope * xx + 2.0 * lens.p1 * p.y + 6.0 * lens.p2 * p.x, across,  //
                      across, radial + slope * yy + 6.0 * lens.p1 * p.y + 2.0 * lens.p2 * p.x};
  return moved;
}

double determinant(const cv::Matx22d& m) { return m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0); }

cv::Point2d solve(const cv::Matx22d& m, cv::Point2d rhs) {
  const double d = determinant(m);
  return {(m(1, 1) * rhs.x - m(0, 1) * rhs.y) / d, (m(0, 0) * rhs.y - m(1, 0) * rhs.x) / d};
}

cv::Matx22d inverse(const cv::Matx22d& m) {
  const double d = determinant(m);
  return {m(1, 1) / d, -m(0, 1) / d, -m(1, 0) / d, m(0, 0) / d};
}

/// Newton's iteration; it stops where the polynomial folds over, beyond which no point of a lens lies.
cv::Point2d undistort(const LensDistortion& lens, cv::Point2d distorted) {
  constexpr int kMaxSteps = 20;
  constexpr double kMinDeterminant = 0.05;
  constexpr double kCloseEnough = 1e-13;
  cv::Point2d p = distorted;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Moved moved = distort(lens, p);
    if (!(determinant(moved.derivative) > kMinDeterminant)) break;
    const cv::Point2d change = solve(moved.derivative, distorted - moved.at);
    p += change;
    if (std::abs(change.x) + std::abs(change.y) < kCloseEnough) break;
  }
  return p;
}

cv::Point2d apply(const cv::Matx33d& h, cv::Point2d p) {
  const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
  return {(h(0, 0) * p.x + h(0, 1) * p.y + h(0, 2)) / w, (h(1, 0) * p.x + h(1, 1) * p.y + h(1, 2)) / w};
}

cv::Matx22d derivative_of(const cv::Matx33d& h, cv::Point2d p) {
  const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
  const cv::Point2d q = apply(h, p);
  return {(h(0, 0) - h(2, 0) * q.x) / w, (h(0, 1) - h(2, 1) * q.x) / w,  //
          (h(1, 0) - h(2, 0) * q.y) / w, (h(1, 1) - h(2, 1) * q.y) / w};
}

}  // namespace

PlaneMap PlaneMap::uncalibrated(int height_px) {
  PlaneMap map;
  map.height_px_ = height_px;
  return map;
}

PlaneMap PlaneMap::calibrated(const LensDistortion& lens, const cv::Matx33d& rectify,
                              const std::optional<Viewpoint>& viewpoint) {
  PlaneMap map;
  map.uncalibrated_ = false;
  map.lens_ = lens;
  map.rectify_ = rectify;
  map.unrectify_ = rectify.inv();
  map.viewpoint_ = viewpoint;
  return map;
}

PlaneMap PlaneMap::on_enlarged(double factor) const {
  PlaneMap map = *this;
  map.enlarged_ *= factor;
  return map;
}

// Pixels' centres are at integers.
cv::Point2d PlaneMap::own(cv::Point2d enlarged_px) const {
  if (enlarged_ == 1.0) return enlarged_px;
  return {(enlarged_px.x + 0.5) / enlarged_ - 0.5, (enlarged_px.y + 0.5) / enlarged_ - 0.5};
}

cv::Point2d PlaneMap::to_plane(cv::Point2d image_px) const { return own_to_plane(own(image_px)); }

cv::Point2d PlaneMap::to_image(cv::Point2d plane_px) const {
  const cv::Point2d at = plane_to_own(plane_px);
  if (enlarged_ == 1.0) return at;
  return {(at.x + 0.5) * enlarged_ - 0.5, (at.y + 0.5) * enlarged_ - 0.5};
}

cv::Matx22d PlaneMap::jacobian(cv::Point2d image_px) const {
  return own_jacobian(own(image_px)) * (1.0 / enlarged_);
}

cv::Point2d PlaneMap::own_to_plane(cv::Point2d image_px) const {
  if (uncalibrated_) return {image_px.x, height_px_ - 1.0 - image_px.y};
  const cv::Point2d ideal = undistort(lens_, (image_px - lens_.centre_px) * (1.0 / lens_.focal_px));
  return apply(rectify_, ideal * lens_.focal_px + lens_.centre_px);
}

cv::Point2d PlaneMap::plane_to_own(cv::Point2d plane_px) const {
  if (uncalibrated_) return {plane_px.x, height_px_ - 1.0 - plane_px.y};
  const cv::Point2d ideal = (apply(unrectify_, plane_px) - lens_.centre_px) * (1.0 / lens_.focal_px);
  return distort(lens_, ideal).at * lens_.focal_px + lens_.centre_px;
}

cv::Matx22d PlaneMap::own_jacobian(cv::Point2d image_px) const {
  if (uncalibrated_) return {1.0, 0.0, 0.0, -1.0};
  const cv::Point2d ideal = undistort(lens_, (image_px - lens_.centre_px) * (1.0 / lens_.focal_px));
  return derivative_of(rectify_, ideal * lens_.focal_px + lens_.centre_px) *
         inverse(distort(lens_, ideal).derivative);
}

double PlaneMap::image_px_per_plane_px(cv::Point2d image_px) const {
  return 1.0 / std::sqrt(std::abs(determinant(jacobian(image_px))));
}

EllipsePx PlaneMap::outline(cv::Point2d centre_px, double diameter_px) const {
  const double radius = 0.5 * diameter_px;
  if (!viewpoint_) return {centre_px, radius, radius, 0.0};
  // The cone of sight around the sphere, half angle beta, at theta to the perpendicular, cut by the plane.
  const cv::Point2d from_foot = centre_px - viewpoint_->foot_px;
  const double distance = viewpoint_->distance_px;
  const double off = std::hypot(from_foot.x, from_foot.y);
  const double slant = std::hypot(off, distance);
  const double sin_beta = std::min(radius / slant, 0.999);
  const double sin_theta = off / slant, cos_theta = distance / slant;
  const double cos2_beta = 1.0 - sin_beta * sin_beta;
  const double q = std::max(cos_theta * cos_theta - sin_beta * sin_beta, 1e-6);
  const cv::Point2d direction = off > 0.0 ? from_foot * (1.0 / off) : cv::Point2d(1.0, 0.0);
  EllipsePx ellipse;
  ellipse.centre = viewpoint_->foot_px + direction * (distance * sin_theta * cos_theta / q);
  ellipse.along = distance * sin_beta * std::sqrt(cos2_beta) / q;
  ellipse.across = distance * sin_beta / std::sqrt(q);
  ellipse.axis_rad = std::atan2(direction.y, direction.x);
  return ellipse;
}

}  // namespace strobe::digitize
