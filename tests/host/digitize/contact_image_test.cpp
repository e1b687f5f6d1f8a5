// A flattened ball against the geometry of a circle cut by a line, and its uncertainty against numerical
// derivatives.
#include "host/digitize/surface/contact_image.hpp"

#include <array>
#include <cmath>
#include <functional>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::digitize;

constexpr double kRadius_px = 130.0;
constexpr double kTilt_rad = 0.06;

/// Two points, so that the line's height is as uncertain as one of them.
SurfaceLine surface(double sd_px) {
  SurfaceLine line;
  const cv::Point2d along(std::cos(kTilt_rad), std::sin(kTilt_rad));
  line.points = {cv::Point2d(500.0, 200.0) - 400.0 * along, cv::Point2d(500.0, 200.0) + 400.0 * along};
  line.sd_px = sd_px;
  return line;
}

cv::Point2d up() { return {-std::sin(kTilt_rad), std::cos(kTilt_rad)}; }

/// `height_px`: of the centre above the surface.
Outline ball(double height_px) {
  Outline outline;
  outline.centre = cv::Point2d(500.0, 200.0) + height_px * up();
  outline.diameter = 2.0 * kRadius_px;
  outline.covariance = cv::Matx33d(0.05, 0.01, -0.02, 0.01, 0.08, 0.03, -0.02, 0.03, 0.12);
  return outline;
}

/// Propagates the outline's covariance through a function by central differences.
double sd_by_differences(const Outline& outline, const std::function<double(const Outline&)>& value) {
  constexpr double kStep = 1e-4;
  cv::Vec3d gradient;
  for (int a = 0; a < 3; ++a) {
    std::array<double, 2> ends{};
    for (const int side : {0, 1}) {
      Outline moved = outline;
      const double by = side == 0 ? -kStep : kStep;
      if (a == 0) moved.centre.x += by;
      if (a == 1) moved.centre.y += by;
      if (a == 2) moved.diameter += by;
      ends[static_cast<std::size_t>(side)] = value(moved);
    }
    gradient[a] = (ends[1] - ends[0]) / (2.0 * kStep);
  }
  return std::sqrt(gradient.dot(outline.covariance * gradient));
}

}  // namespace

TEST_GROUP(ContactImage){};

TEST(ContactImage, HasItsTopARadiusAboveTheCentreAndTheChordsWidth) {
  const auto contact = measure_contact(ball(80.0), surface(0.0));
  CHECK_TRUE(contact.has_value());
  const cv::Point2d top = cv::Point2d(500.0, 200.0) + (80.0 + kRadius_px) * up();
  DOUBLES_EQUAL(top.x, contact->top.x, 1e-9);
  DOUBLES_EQUAL(top.y, contact->top.y, 1e-9);
  DOUBLES_EQUAL(2.0 * std::sqrt(kRadius_px * kRadius_px - 80.0 * 80.0), *contact->width_px, 1e-9);
}

TEST(ContactImage, HasTheSdOfTheGeometry) {
  const SurfaceLine line = surface(0.0);
  const auto contact = measure_contact(ball(80.0), line);
  // Central differences of a smooth function over 1e-4 px err by some 1e-10 relative.
  const double top_sd = sd_by_differences(
      ball(80.0), [&](const Outline& o) { return measure_contact(o, line)->top.dot(up()); });
  const double width_sd = sd_by_differences(ball(80.0), [&](const Outline& o) {
    const double height = (o.centre - cv::Point2d(500.0, 200.0)).dot(up());
    return 2.0 * std::sqrt(0.25 * o.diameter * o.diameter - height * height);
  });
  DOUBLES_EQUAL(top_sd, contact->top_sd_px, 1e-6);
  DOUBLES_EQUAL(width_sd, *contact->width_sd_px, 1e-6);
}

TEST(ContactImage, WidthIsAsUncertainAsTheSurfaceToo) {
  const double without = *measure_contact(ball(80.0), surface(0.0))->width_sd_px;
  const double with = *measure_contact(ball(80.0), surface(1.5))->width_sd_px;
  // d(width)/d(height) of width = 2·sqrt(r² - h²).
  const double slope = 2.0 * 80.0 / std::sqrt(kRadius_px * kRadius_px - 80.0 * 80.0);
  DOUBLES_EQUAL(std::hypot(without, 1.5 * slope), with, 1e-9);
}

TEST(ContactImage, OfABallAboveTheSurfaceHasNoWidth) {
  const auto contact = measure_contact(ball(kRadius_px + 0.5), surface(0.1));
  CHECK_TRUE(contact.has_value());
  CHECK_FALSE(contact->width_px.has_value());
}

TEST(ContactImage, OfAGrazingCutHasNoWidth) {
  // 0.5 px into the surface: half the width is 11 px, and its sd 2·h/half = 23 times that of the height.
  const auto contact = measure_contact(ball(kRadius_px - 0.5), surface(2.0));
  CHECK_TRUE(contact.has_value());
  CHECK_FALSE(contact->width_px.has_value());
}

TEST(ContactImage, OfAnUncertainOutlineIsRejected) {
  Outline outline = ball(80.0);
  outline.covariance = cv::Matx33d::eye() * 200.0;  // sd of the top: sqrt(200·1.25) = 15.8 px of 260
  const auto contact = measure_contact(outline, surface(0.0));
  CHECK_FALSE(contact.has_value());
  CHECK_EQUAL(Reason::imprecise, contact.error().reason);
}
