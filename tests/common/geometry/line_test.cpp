// Lines and axes against figures worked out by hand.
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/geometry/line.hpp"
#include "common/geometry/leg.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::geometry;
using Eigen::Vector2d;

namespace {

constexpr double kRounding = 1e-14;

void equal(const Vector2d& expected, const Vector2d& actual, double tolerance = kRounding) {
  DOUBLES_EQUAL(expected.x(), actual.x(), tolerance);
  DOUBLES_EQUAL(expected.y(), actual.y(), tolerance);
}

}  // namespace

TEST_GROUP(Rotations){};

TEST(Rotations, TurnCounterClockwiseAndBack) {
  equal({0.0, 1.0}, Rotation2d(std::numbers::pi / 2) * Vector2d(1.0, 0.0));
  const Rotation2d rotation(0.3);
  equal({2.0, -5.0}, rotation.inverse() * (rotation * Vector2d(2.0, -5.0)));
  equal({2.0, -5.0}, Rotation2d() * Vector2d(2.0, -5.0));
}

TEST_GROUP(LineFits){};

TEST(LineFits, GoThroughPointsOfALineWhateverItsTilt) {
  for (const double tilt : {-1.5, -0.4, 0.0, 0.7, 1.5}) {
    const Vector2d along(std::cos(tilt), std::sin(tilt));
    const std::vector<Vector2d> points{Vector2d(3.0, 4.0) - 2.0 * along, Vector2d(3.0, 4.0) + 5.0 * along,
                                       Vector2d(3.0, 4.0) + 6.0 * along};
    const auto line = fit_line(points);
    CHECK_TRUE(line.has_value());
    equal(along, line->direction());
    equal(Vector2d(3.0, 4.0) + 3.0 * along, line->origin());
    equal({7.0, 2.0},
          line->coordinates(line->origin() + 7.0 * along + 2.0 * Vector2d(-along.y(), along.x())));
  }
}

TEST(LineFits, MinimizeTheDistanceNotTheHeight) {
  // Scatter matrix [[8, 4], [4, 2 + 2/3 ...]]: its main axis, tan 2a = 2 sxy / (sxx - syy).
  const std::array<Vector2d, 3> points{Vector2d(0.0, 0.0), Vector2d(2.0, 2.0), Vector2d(4.0, 1.0)};
  // About the mean (2, 1): sxx = 8, sxy = 2, syy = 2.
  const auto line = fit_line(points);
  DOUBLES_EQUAL(0.5 * std::atan2(4.0, 6.0), std::atan2(line->direction().y(), line->direction().x()),
                kRounding);
}

TEST(LineFits, WeighAPointAsManyTimesAsItsWeightSays) {
  const std::array<Vector2d, 3> points{Vector2d(0.0, 0.0), Vector2d(2.0, 2.0), Vector2d(4.0, 1.0)};
  const std::array<Vector2d, 4> twice{points[0], points[1], points[1], points[2]};
  const auto weighted = fit_line(points, std::array{0.5, 1.0, 0.5});
  const auto repeated = fit_line(twice);
  equal(repeated->origin(), weighted->origin());
  equal(repeated->direction(), weighted->direction());
}

TEST(LineFits, KeepTheirDigitsFarFromTheOrigin) {
  const std::array<Vector2d, 2> near{Vector2d(0.0, 0.0), Vector2d(3.0, 1.0)};
  const std::array<Vector2d, 2> far{Vector2d(1e12, -1e12), Vector2d(1e12 + 3.0, -1e12 + 1.0)};
  equal(fit_line(near)->direction(), fit_line(far)->direction());
  equal(fit_line(near)->coordinates(near[1]), fit_line(far)->coordinates(far[1]));
}

TEST(LineFits, OfOnePointAreNone) {
  CHECK_FALSE(fit_line({}).has_value());
  const std::array<Vector2d, 2> same{Vector2d(1.0, 2.0), Vector2d(1.0, 2.0)};
  CHECK_FALSE(fit_line(same).has_value());
  // About their mean the two are 1.5 and 1.5 away: root of the sum of squares 2.12.
  const std::array<Vector2d, 2> apart{Vector2d(0.0, 0.0), Vector2d(3.0, 0.0)};
  CHECK_TRUE(fit_line(apart, {}, 2.12).has_value());
  CHECK_FALSE(fit_line(apart, {}, 2.13).has_value());
  const std::array<Vector2d, 2> nowhere{Vector2d(0.0, 0.0), Vector2d(std::nan(""), 0.0)};
  CHECK_FALSE(fit_line(nowhere).has_value());
}

TEST_GROUP(Regressions){};

TEST(Regressions, GiveMeanSlopeAndTheirVariances) {
  // x 0, 1, 3 with weights 1, 2, 1: mean 1.25, moment 4.75; values 1, 3, 6: mean 3.25, slope 7.75/4.75.
  LinearRegression<double> line;
  line.add(0.0, 1.0, 1.0);
  line.add(1.0, 3.0, 2.0);
  line.add(3.0, 6.0, 1.0);
  DOUBLES_EQUAL(4.0, line.weight(), kRounding);
  DOUBLES_EQUAL(1.25, line.mean_x(), kRounding);
  DOUBLES_EQUAL(3.25, line.mean(), kRounding);
  DOUBLES_EQUAL(4.75, line.moment(), kRounding);
  DOUBLES_EQUAL(7.75 / 4.75, line.slope(), kRounding);
  DOUBLES_EQUAL(3.25 - 1.25 * 7.75 / 4.75, line.at(0.0), kRounding);
  DOUBLES_EQUAL(1.0 / 4.75, line.slope_variance(), kRounding);
  DOUBLES_EQUAL(0.25 + 1.25 * 1.25 / 4.75, line.variance_at(0.0), kRounding);
}

TEST(Regressions, OfVectorsAreThoseOfTheirComponents) {
  LinearRegression<Vector2d> both;
  LinearRegression<double> y;
  for (int i = 0; i < 5; ++i) {
    both.add(i, {1.0 + 2.0 * i, std::sin(i)}, 1.0 + i);
    y.add(i, std::sin(i), 1.0 + i);
  }
  equal({2.0, y.slope()}, both.slope());
  equal({1.0 + 2.0 * 7.0, y.at(7.0)}, both.at(7.0));
}

TEST(Regressions, KeepALightSampleBesideAHeavyOne) {
  // A weight of 1e20 beside 1: the moment about the mean, 1e20 / (1e20 + 1), is the light one's, all its digits.
  LinearRegression<double> line;
  line.add(0.0, 0.0, 1e20);
  line.add(1.0, 2.0, 1.0);
  DOUBLES_EQUAL(1.0, line.moment(), kRounding);
  DOUBLES_EQUAL(2.0, line.slope(), kRounding);
}

TEST_GROUP(SurfaceFrames){};

TEST(SurfaceFrames, MeasureAlongAndUpFromTheSurface) {
  const double tilt = 0.1;
  const Vector2d along(std::cos(tilt), std::sin(tilt));
  const Vector2d up(-along.y(), along.x());
  const std::array<Vector2d, 2> points{Vector2d(100.0, 50.0), Vector2d(100.0, 50.0) + 200.0 * along};
  SurfaceFrame frame{.line = *fit_line(points), .px_per_unit = 4.0};
  const Vector2d ball = points[0] + 140.0 * along + 60.0 * up;
  equal({10.0, 15.0}, frame.from_image(ball), 1e-12);
  equal({40.0, 60.0}, SurfaceFrame{.line = frame.line}.from_image(ball), 1e-12);
  equal(ball, frame.to_image({10.0, 15.0}), 1e-12);
  frame.mirrored = true;
  equal({-10.0, 15.0}, frame.from_image(ball), 1e-12);
  equal(ball, frame.to_image({-10.0, 15.0}), 1e-12);
}
