// Outlines distinguished from arcs that only look like one, by the light across them.
#include "host/digitize/outliers/limb_agreement.hpp"

#include <random>

#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;
namespace painter = strobe::testing;

constexpr double kLimb_px = 80.0;
constexpr int kHeight = 300;

/// Images in a row that overlap, 3/4 of a diameter apart.
painter::Painting row_of_balls(std::uint64_t seed, int count, double light) {
  std::mt19937_64 random(seed);
  painter::Painting painting;
  painting.width = 560;
  painting.height = kHeight;
  painting.bits = 16;
  painting.seed = seed;
  painter::PaintedBall look = painter::random_ball(random, {}, kLimb_px);
  look.light = light;
  for (int k = 0; k < count; ++k) {
    look = painter::next_image(look, {80.0 + 60.0 * k, 200.0 - 12.0 * k}, 0.2);
    painting.balls.push_back(look);
  }
  return painting;
}

Outline outline_at(cv::Point2d image_px) {
  Outline outline;
  outline.centre = {image_px.x, kHeight - 1 - image_px.y};
  outline.diameter = kLimb_px;
  outline.blur_px = 1.0;
  return outline;
}

std::vector<LimbAgreement> looked_at(const painter::Painting& painting, const std::vector<Outline>& outlines,
                                     const std::optional<SurfaceLine>& surface = std::nullopt) {
  return compare_limbs(painter::paint(painting), PlaneMap::uncalibrated(kHeight), outlines, surface);
}

}  // namespace

TEST_GROUP(LimbAgreement){};

TEST(LimbAgreement, KnowsABallsLimbWhereFalseOutlinesOutnumberTheBalls) {
  const auto painting = row_of_balls(5, 4, 0.12);
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) {
    outlines.push_back(outline_at(ball.centre));
    outlines.back().visible_fraction = 0.8;
  }
  // On the even background above them.
  for (int k = 0; k < 10; ++k) {
    outlines.push_back(outline_at({100.0 + 36.0 * k, 60.0}));
    outlines.back().visible_fraction = 0.25;
  }
  const auto limbs = looked_at(painting, outlines);
  for (std::size_t i = 0; i < painting.balls.size(); ++i) CHECK_TRUE(limbs[i].is_certain_ball());
  for (std::size_t i = painting.balls.size(); i < limbs.size(); ++i)
    CHECK_TRUE(limbs[i].is_certain_non_ball());
}

TEST(LimbAgreement, TellsBallsFromACircleHalfWayBetweenTwo) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto painting = row_of_balls(seed, 6, 0.12);
    std::vector<Outline> outlines;
    for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
    outlines.push_back(outline_at(0.5 * (painting.balls[2].centre + painting.balls[3].centre)));
    const auto limbs = looked_at(painting, outlines);
    for (std::size_t i = 0; i + 1 < outlines.size(); ++i) CHECK_TRUE(limbs[i].agreement > 0.6);
    CHECK_TRUE(limbs.back().agreement < 0.5);
  }
}

TEST(LimbAgreement, MindsNeitherALampThatFailsNorAFlashThatIsWeak) {
  auto painting = row_of_balls(5, 6, 0.2);
  for (auto& ball : painting.balls) ball.lamps.resize(1);
  painting.balls[3].light *= 0.5;
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  for (const LimbAgreement& limb : looked_at(painting, outlines)) CHECK_TRUE(limb.agreement > 0.6);
}

TEST(LimbAgreement, SaysHowLittleCanBeTold) {
  const auto painting = row_of_balls(3, 5, 2.5);  // overlaps and middles saturated
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  outlines.push_back(outline_at({5.0, 290.0}));  // a quarter is on the photograph
  const auto limbs = looked_at(painting, outlines);
  CHECK_TRUE(limbs[2].observed < 0.9);
  CHECK_TRUE(limbs.back().observed < 0.45);
}

TEST(LimbAgreement, LeavesOutWhatLiesBelowTheSurface) {
  const auto painting = row_of_balls(7, 4, 0.2);
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  SurfaceLine surface;  // through the first ball's middle
  surface.points = {{0.0, outlines[0].centre.y}, {560.0, outlines[0].centre.y}};
  const auto limbs = looked_at(painting, outlines, surface);
  // A half, but for the directions on the line itself.
  DOUBLES_EQUAL(0.5, limbs[0].observed, 0.06);
  CHECK_TRUE(limbs[3].observed > 0.75);  // 36 px higher: little of it lies below
}

TEST(LimbAgreement, OfNothingIsNothing) { LONGS_EQUAL(0, looked_at(row_of_balls(1, 0, 0.2), {}).size()); }
