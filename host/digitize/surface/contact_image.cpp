#include "host/digitize/surface/contact_image.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/digitize/core/eigen.hpp"

namespace strobe::digitize {
namespace {

constexpr double kMaxTopSdOfDiameter = 0.05;
// Where the surface cuts the outline at a grazing angle the width is meaningless.
constexpr double kMaxWidthSdOfDiameter = 0.15;

}  // namespace

Measured<ContactImage> measure_contact(const Outline& outline, const SurfaceLine& surface) {
  const geometry::SurfaceFrame axes = surface_frame(surface);
  const cv::Point2d up = to_point(axes.line.tilt * Eigen::Vector2d::UnitY());
  const double radius = 0.5 * outline.diameter;
  ContactImage contact;
  contact.top = outline.centre + radius * up;
  const cv::Vec3d top_by(up.x, up.y, 0.5);
  contact.top_sd_px = std::sqrt(top_by.dot(outline.covariance * top_by));
  if (!(contact.top_sd_px <= kMaxTopSdOfDiameter * outline.diameter)) {
    return tl::unexpected(Rejection{
        Reason::imprecise, fmt::format("the top of the ball is known to {:.1f} px only", contact.top_sd_px)});
  }
  const double height = axes.from_image(to_eigen(outline.centre)).y();
  const double half2 = radius * radius - height * height;
  if (half2 <= 0.0) return contact;
  // The chord that the surface cuts off: (w/2)² = r² - h².
  const double half = std::sqrt(half2);
  const cv::Vec3d width_by(-2.0 * height / half * up.x, -2.0 * height / half * up.y, radius / half);
  const double surface_part = 2.0 * height / half * height_sd_px(surface);
  const double sd = std::sqrt(width_by.dot(outline.covariance * width_by) + surface_part * surface_part);
  if (sd > kMaxWidthSdOfDiameter * outline.diameter) return contact;
  contact.width_px = 2.0 * half;
  contact.width_sd_px = sd;
  return contact;
}

}  // namespace strobe::digitize
