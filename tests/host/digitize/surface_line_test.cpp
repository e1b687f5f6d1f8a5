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

/// Scratches of many lengths on the plate, up to the edge at `row`, on what stepped() paints at a slope of .013.
Photograph uneven(Photograph photograph, double row, std::uint64_t seed) {
  cv::RNG random(seed);
  for (int scratch = 0; scratch < 40; ++scratch) {
    const int from = random.uniform(0, kWidth), length = random.uniform(3, 25);
    const double lighter = random.gaussian(0.03), deep = random.uniform(0.0, 4.0);
    for (int x = from; x < std::min(kWidth, from + length); ++x) {
      const int top = static_cast<int>(std::ceil(row + 0.013 * (x - 300) + deep));
      for (int y = top; y < std::min(kHeight, top + 6); ++y)
        photograph.intensity.at<float>(y, x) += static_cast<float>(lighter);
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

TEST(SurfaceLine, OfASaturatedPlateLiesWhereItsEdgeIsAndNotWhereTheLightIsCutOff) {
  // Twice and four times as light as what saturates: the steepest rise of what is left lies .3 and .8 px too high.
  for (const double share : {2.0, 4.0}) {
    Photograph photograph = stepped({220.3}, 0.01, share * 5.0);
    cv::min(photograph.intensity, 1.0, photograph.intensity);
    const auto line = found(photograph);
    CHECK_TRUE(line.has_value());
    const double off = height_above(*line, {300.0, kHeight - 1 - 220.3});
    DOUBLES_EQUAL(0.0, off, 0.15);
    // What the lens's tails leave unknown is said.
    CHECK_TRUE(std::abs(off) < 4.0 * height_sd_px(*line));
  }
}

TEST(SurfaceLine, IsAsFarFromTheTruthAsItsSdSays) {
  // Errors over sds of 60 pictures with uneven plates: the rms of as many numbers errs by 1/sqrt(120) = 9 %, and the
  // sds themselves, of 8 and 24 blocks, by a tenth: 3 such sds are .4.
  double squares = 0.0;
  constexpr int kPictures = 60;
  for (int k = 0; k < kPictures; ++k) {
    const double row = 218.0 + 0.05 * k;
    const auto line = found(uneven(stepped({row}, 0.013), row, static_cast<std::uint64_t>(k) + 7));
    CHECK_TRUE(line.has_value());
    // Of four points, the mean's variance is a quarter of one's.
    squares += std::pow(height_above(*line, {300.0, kHeight - 1 - row}) / (0.5 * line->sd_px), 2);
  }
  DOUBLES_EQUAL(1.0, std::sqrt(squares / kPictures), 0.4);
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
