#include "host/digitize/equator/disc.hpp"

#include <algorithm>
#include <numbers>

namespace strobe::digitize {

double LineShape::darkness(double f) const {
  const double scale = 1.0 / (std::numbers::sqrt2 * soft);
  const double full = std::erf(half_width * scale);
  return 0.5 * (std::erf((f + half_width) * scale) - std::erf((f - half_width) * scale)) / full;
}

double LineShape::derivative(double f) const {
  const auto bell = [&](double x) { return std::exp(-0.5 * (x / soft) * (x / soft)); };
  const double full = std::erf(half_width / (std::numbers::sqrt2 * soft));
  return (bell(f + half_width) - bell(f - half_width)) / (std::sqrt(2.0 * std::numbers::pi) * soft * full);
}

ShapeTable::ShapeTable(const LineShape& shape)
    : reach_(shape.reach()), per_radius_(kSteps / std::max(1e-9, reach_)) {
  for (int k = 0; k <= kSteps; ++k) {
    const double f = reach_ * k / kSteps;
    dark_[static_cast<std::size_t>(k)] = shape.darkness(f);
    derivative_[static_cast<std::size_t>(k)] = shape.derivative(f);
  }
}

cv::Point2d Disc::half_extent_px(double radii) const {
  return {radii * std::hypot(image_from_unit(0, 0), image_from_unit(0, 1)),
          radii * std::hypot(image_from_unit(1, 0), image_from_unit(1, 1))};
}

Disc make_disc(const PlaneMap& map, const Outline& outline) {
  Disc disc;
  disc.centre_image = map.to_image(outline.centre);
  const EllipsePx ellipse = map.outline(outline.centre, outline.diameter);
  const double c = std::cos(ellipse.axis_rad), s = std::sin(ellipse.axis_rad);
  const cv::Matx22d turn(c, -s, s, c);
  disc.plane_from_unit = turn * cv::Matx22d(ellipse.along, 0.0, 0.0, ellipse.across) * turn.t();
  disc.unit_from_image = disc.plane_from_unit.inv() * map.jacobian(disc.centre_image);
  disc.image_from_unit = disc.unit_from_image.inv();
  disc.radius_image_px = std::sqrt(std::abs(cv::determinant(disc.image_from_unit)));
  // Two sd of the edge's blur to either side, and about a pixel of the felt's fuzz.
  const double disturbed_px = 2.0 * std::clamp(outline.blur_px, 0.5, 8.0) + 1.5;
  disc.rim = disturbed_px / disc.radius_image_px;
  const double variance = 0.5 * (outline.covariance(0, 0) + outline.covariance(1, 1));
  disc.centre_sd = std::sqrt(std::max(0.0, variance)) / (0.5 * outline.diameter);
  return disc;
}

bool is_valid(const Disc& disc) {
  return std::isfinite(disc.centre_image.x) && std::isfinite(disc.centre_image.y) &&
         std::isfinite(disc.radius_image_px) && disc.radius_image_px >= 1.0 && disc.radius_image_px <= 1e5 &&
         std::isfinite(disc.centre_sd);
}

}  // namespace strobe::digitize
