#include "host/digitize/surface/surface_line.hpp"

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::digitize;

constexpr int kWidth = 600, kHeight = 300;

/// Light rises at each of these rows, softly, on a picture with a little noise; by less at the first, if
/// asked.
Photograph stepped(const std::vector<double>& rows, double slope = 0.0, double first = 1.0) {
  Photograph photograph;
  photograph.intensity.create(kHeight, kWidth, CV_32FC1);
  cv::RNG random(3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double light = 0.05 + random.gaussian(0.002), rise = 0.1 * first;
      for (const double row : rows) {
        light += rise * std::erfc(-(y - row - slope * (x - 300)) / 1.5);
        rise = 0.1;
      }
      photograph.intensity.at<float>(y, x) = static_cast<float>(light);
    }
  }
  return photograph;
}

Outline ball_at(double x, double y) {
  Outline outline;
  outline.centre = {x, y};
  outline.diameter = 60.0;
  return outline;
}

Measured<SurfaceLine> found(const Photograph& photograph) {
  const std::vector<Outline> outlines{ball_at(150.0, 180.0), ball_at(300.0, 102.0), ball_at(420.0, 160.0)};
  return find_surface_line(photograph, PlaneMap::uncalibrated(kHeight), outlines);
}

double height_above(const SurfaceLine& line, const Eigen::Vector2d& point) {
  return surface_frame(line).from_image(point).y();
}

}  // namespace

TEST_GROUP(SurfaceLine){};

TEST(SurfaceLine, OfAPlateSeenEdgeOnIsItsEdge) {
  const auto line = found(stepped({220.3}, 0.01));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
  CHECK_TRUE(height_sd_px(*line) < 0.15);
}

TEST(SurfaceLine, OfAPlateSeenFromAboveLiesBetweenItsEdgesAndSaysSo) {
  const auto line = found(stepped({212.0, 236.0}));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(24.0, line->edge_separation_px, 0.2);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 224.0}), 0.2);
  // Anywhere between them alike: 24 px/sqrt(12) = 6.9; of four points as if of three: 8.
  CHECK_TRUE(height_sd_px(*line) > 6.8 && height_sd_px(*line) < 8.1);
}

TEST(SurfaceLine, OfAPlateIsNotDrawnToAFaintEdgeOfTheBackground) {
  const auto line = found(stepped({190.0, 220.3}, 0.0, 0.03));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
}

TEST(SurfaceLine, IsNotDrawnToTheTopOfAClampThatBallsReachBelow) {
  // 44 px above the plate; half-way would cut a third of the lower ball off, all of which is seen.
  std::vector<Outline> balls{ball_at(200.0, 112.0), ball_at(400.0, 116.0)};
  for (Outline& ball : balls) ball.visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const auto line = find_surface_line(stepped({176.3, 220.3}), PlaneMap::uncalibrated(kHeight), balls);
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
}

TEST(SurfaceLine, OfABarFarBelowThePlateIsNotItsOtherEdge) {
  const auto line = found(stepped({212.0, 280.0}));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
}

TEST(SurfaceLine, IsNotOneThatBallsAreSeenBelow) {
  // The upper edge is as clear and nearer to the balls, but both reach 20 px below it.
  std::vector<Outline> balls{ball_at(200.0, 160.0), ball_at(400.0, 160.0)};
  for (Outline& ball : balls) ball.visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const auto lower = find_surface_line(stepped({150.0, 220.3}), PlaneMap::uncalibrated(kHeight), balls);
  CHECK_TRUE(lower.has_value());
  DOUBLES_EQUAL(0.0, height_above(*lower, {300.0, kHeight - 1 - 220.3}), 0.1);
  const auto none = find_surface_line(stepped({150.0}), PlaneMap::uncalibrated(kHeight), balls);
  CHECK_FALSE(none.has_value());
  CHECK_EQUAL(Reason::no_plate, none.error().reason);
}

TEST(SurfaceLine, IsNotVetoedByOneFalseOutlineOfManyBelow) {
  std::vector<Outline> outlines;
  for (int k = 0; k < 7; ++k) outlines.push_back(ball_at(100.0 + 60.0 * k, 112.0 + 20.0 * std::abs(k - 3)));
  outlines.push_back(ball_at(540.0, 70.0));  // a clamp's, astride the edge
  for (Outline& outline : outlines) outline.visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const Photograph photograph = stepped({220.3});
  const auto line = find_surface_line(photograph, PlaneMap::uncalibrated(kHeight), outlines);
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
  // Of seven one is too many.
  outlines.erase(outlines.begin());
  CHECK_FALSE(find_surface_line(photograph, PlaneMap::uncalibrated(kHeight), outlines).has_value());
}

TEST(SurfaceLine, MayCutOffWhatIsNotSeenOfABall) {
  // Pressed together by a third of its radius: the outline is seen above the line alone.
  Outline pressed = ball_at(300.0, 98.7);
  pressed.visible_arcs = {{-0.6, std::numbers::pi + 1.2}};
  const auto line =
      find_surface_line(stepped({220.3}), PlaneMap::uncalibrated(kHeight), std::vector<Outline>{pressed});
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
}

TEST(SurfaceLine, OfNoPlateIsNone) {
  const auto line = found(stepped({}));
  CHECK_FALSE(line.has_value());
  CHECK_EQUAL(Reason::no_plate, line.error().reason);
}
