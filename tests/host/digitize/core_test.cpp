#include <cmath>
#include <set>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/core/types.hpp"

#include <CppUTest/TestHarness.h>

using strobe::digitize::name;
using strobe::digitize::Reason;

TEST_GROUP(Reason){};

TEST(Reason, HasANameOfItsOwn) {
  std::set<std::string_view> names;
  const int count = static_cast<int>(Reason::by_hand) + 1;
  for (int i = 0; i < count; ++i) names.insert(name(static_cast<Reason>(i)));
  LONGS_EQUAL(count, names.size());
}

using namespace strobe::digitize;

TEST_GROUP(Statistics){};

TEST(Statistics, AQuantileIsTheValueOfItsRank) {
  const std::vector<int> values{5, 1, 4, 2, 3};
  LONGS_EQUAL(4, quantile(values, 3, 4));
  LONGS_EQUAL(4, quantile(values, 7, 10));
  LONGS_EQUAL(3, upper_median(values));
  LONGS_EQUAL(0, quantile(std::vector<int>{}, 3, 4));
}

TEST(Statistics, TheMedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  DOUBLES_EQUAL(2.5, median({4.0, 1.0, 3.0, 2.0}), 0.0);
  DOUBLES_EQUAL(3.0, upper_median(std::vector<double>{4.0, 1.0, 3.0, 2.0}), 0.0);
  DOUBLES_EQUAL(2.0, median({3.0, 1.0, 2.0}), 0.0);
}

// Between photograph and plane: there and back, slopes, and the outline of a sphere against rays.

namespace {

/// A lens that bends its corners by some 2 per cent in front of a plane tilted by some degrees.
PlaneMap bent_and_tilted(std::optional<Viewpoint> viewpoint = {}) {
  const LensDistortion lens{{1437.0, 925.0}, 6000.0, -0.35, 0.6, 4e-4, -3e-4};
  const cv::Matx33d rectify(0.99, 0.01, 12.0, 0.012, -1.01, 1860.0, 8e-6, -5e-6, 1.0);
  return PlaneMap::calibrated(lens, rectify, viewpoint);
}

std::vector<cv::Point2d> places() {
  std::vector<cv::Point2d> points;
  for (double y = -50.0; y < 1900.0; y += 237.0)
    for (double x = -50.0; x < 2950.0; x += 311.0) points.emplace_back(x, y);
  return points;
}

/// Whether the ray from the lens through (x, y) of the plane meets the sphere: by the discriminant.
double clearance(const Viewpoint& eye, cv::Point2d ball, double radius, cv::Point2d at) {
  const cv::Vec3d lens(eye.foot_px.x, eye.foot_px.y, eye.distance_px);
  const cv::Vec3d ray = cv::normalize(cv::Vec3d(at.x, at.y, 0.0) - lens);
  const cv::Vec3d to_ball = cv::Vec3d(ball.x, ball.y, 0.0) - lens;
  return cv::norm(to_ball - ray * to_ball.dot(ray)) - radius;
}

}  // namespace

TEST_GROUP(PlaneMap){};

TEST(PlaneMap, WithoutACalibrationTurnsRowsUpsideDown) {
  const PlaneMap map = PlaneMap::uncalibrated(1840);
  CHECK_TRUE(map.is_uncalibrated());
  const cv::Point2d p = map.to_plane({12.5, 1839.0});
  DOUBLES_EQUAL(12.5, p.x, 0);
  DOUBLES_EQUAL(0.0, p.y, 0);
  DOUBLES_EQUAL(-1.0, map.jacobian({3, 4})(1, 1), 0);
  const EllipsePx circle = map.outline({100, 200}, 50.0);
  DOUBLES_EQUAL(25.0, circle.along, 0);
  DOUBLES_EQUAL(25.0, circle.across, 0);
}

TEST(PlaneMap, LeadsBackToWhereItCameFrom) {
  // Rounding: some 1e-16 of 3000 px, a few operations; Newton's iteration ends below 1e-13 focal lengths.
  for (const PlaneMap& map : {PlaneMap::uncalibrated(1840), bent_and_tilted()})
    for (const cv::Point2d& p : places()) CHECK_TRUE(cv::norm(map.to_image(map.to_plane(p)) - p) < 1e-8);
}

TEST(PlaneMap, OfAnEnlargedPhotographLeadsToTheSamePlane) {
  for (const PlaneMap& map : {PlaneMap::uncalibrated(1840), bent_and_tilted()}) {
    const PlaneMap twice = map.on_enlarged(2.0);
    CHECK_FALSE(twice.is_uncalibrated());
    for (const cv::Point2d& own : places()) {
      // Where the four pixels meet that have come of one. Rounding as above.
      const cv::Point2d larger = 2.0 * own + cv::Point2d(0.5, 0.5);
      CHECK_TRUE(cv::norm(twice.to_plane(larger) - map.to_plane(own)) < 1e-8);
      CHECK_TRUE(cv::norm(twice.to_image(map.to_plane(own)) - larger) < 1e-8);
      DOUBLES_EQUAL(2.0 * map.image_px_per_plane_px(own), twice.image_px_per_plane_px(larger), 1e-8);
    }
  }
}

TEST(PlaneMap, KnowsItsSlope) {
  const PlaneMap map = bent_and_tilted();
  // Central differences over h: the third derivative, some 1e-6 per px², times h²/6, and rounding 1e-9/h.
  constexpr double h = 0.01;
  for (const cv::Point2d& p : places()) {
    const cv::Matx22d slope = map.jacobian(p);
    const cv::Point2d along = (map.to_plane({p.x + h, p.y}) - map.to_plane({p.x - h, p.y})) * (0.5 / h);
    const cv::Point2d down = (map.to_plane({p.x, p.y + h}) - map.to_plane({p.x, p.y - h})) * (0.5 / h);
    DOUBLES_EQUAL(along.x, slope(0, 0), 1e-6);
    DOUBLES_EQUAL(along.y, slope(1, 0), 1e-6);
    DOUBLES_EQUAL(down.x, slope(0, 1), 1e-6);
    DOUBLES_EQUAL(down.y, slope(1, 1), 1e-6);
  }
}

TEST(PlaneMap, StaysFiniteWhereTheLensPolynomialFoldsOver) {
  const PlaneMap map =
      PlaneMap::calibrated({{500, 500}, 1000.0, -0.5, 0.0, 0.0, 0.0}, cv::Matx33d::eye(), {});
  for (double x = 0; x < 1e4; x += 100.0) CHECK_TRUE(std::isfinite(map.to_plane({x, 3.0 * x}).x));
}

TEST(PlaneMap, SeesASphereAsTheEllipseThatRaysTouch) {
  const Viewpoint eye{{1450.0, 700.0}, 6100.0};
  const PlaneMap map = bent_and_tilted(eye);
  for (const cv::Point2d& ball :
       {cv::Point2d(200.0, 300.0), cv::Point2d(1450.0, 700.0), cv::Point2d(2800.0, 1700.0)}) {
    const EllipsePx e = map.outline(ball, 260.0);
    const cv::Point2d along(std::cos(e.axis_rad), std::sin(e.axis_rad)), across(-along.y, along.x);
    for (double t = 0.0; t < 6.28; t += 0.1) {
      const cv::Point2d edge = e.centre + along * (e.along * std::cos(t)) + across * (e.across * std::sin(t));
      DOUBLES_EQUAL(0.0, clearance(eye, ball, 130.0, edge), 1e-9);
    }
  }
}

TEST(PlaneMap, SeesASphereAsACircleFromAfar) {
  const PlaneMap map = bent_and_tilted(Viewpoint{{1000, 1000}, 1e9});
  const EllipsePx e = map.outline({300, 200}, 260.0);
  DOUBLES_EQUAL(130.0, e.along, 1e-4);
  DOUBLES_EQUAL(130.0, e.across, 1e-4);
}
