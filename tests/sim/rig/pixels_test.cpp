#include "sim/rig/pixels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/random/draws.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;

constexpr std::uint64_t kSeed = 5;

BallView random_view(Draws& draws, double half_px, double flattening) {
  BallView view;
  view.centre_px = {1000.0 * draws.uniform() - 200.0, 1000.0 * draws.uniform() - 200.0};
  view.along_px = half_px * (1.0 + flattening * draws.uniform());
  view.across_px = half_px;
  view.axis_rad = 6.28 * draws.uniform();
  view.equator_rad = 6.28 * draws.uniform();
  return view;
}

double turned(double a, double b) { return std::abs(std::remainder(a - b, std::numbers::pi)); }

}  // namespace

TEST_GROUP(PixelGrid) { PixelGrid grid; };

TEST(PixelGrid, MeasuresWhatItDrewFarBelowAPixel) {
  // Rounding to 8 bits errs by up to 1/440 of a pixel at each of some 8·r pixels of the outline, at random:
  // sqrt(8·r)/440/sqrt(3)·r/(pi·r²) or 1e-4 px for r = 130 px. The eight lines a row err at the outline's
  // flat top and bottom, by about .2·sqrt(2·r)/8^1.5 px² at each or .004/sqrt(r) px of the centre. Five times
  // that.
  Draws draws(kSeed, Purpose::tablet, 1);
  for (const double half_px : {15.0, 40.0, 130.0}) {
    const double bound = 0.02 / std::sqrt(half_px);
    for (int i = 0; i < 60; ++i) {
      const BallView view = random_view(draws, half_px, 0.05);
      const PixelMeasurement seen = grid.measure(view, {});
      DOUBLES_EQUAL(view.centre_px.x, seen.centre_px.x, bound);
      DOUBLES_EQUAL(view.centre_px.y, seen.centre_px.y, bound);
      DOUBLES_EQUAL(view.diameter_px(), seen.diameter_px, 2.0 * bound);
      CHECK(turned(view.equator_rad, *seen.equator_rad) < PixelGrid::error_rad(half_px));
      CHECK(bound < PixelGrid::error_px(half_px));
    }
  }
}

TEST(PixelGrid, FindsTheMiddleOfABallThatMovedWhileItWasLit) {
  Draws draws(kSeed, Purpose::tablet, 2);
  for (int i = 0; i < 30; ++i) {
    const BallView view = random_view(draws, 60.0, 0.0);
    const PixelMeasurement seen = grid.measure(view, {7.0 * draws.uniform(), -5.0 * draws.uniform(), 0.02});
    DOUBLES_EQUAL(view.centre_px.x, seen.centre_px.x, 1e-3);
    DOUBLES_EQUAL(view.centre_px.y, seen.centre_px.y, 1e-3);
    DOUBLES_EQUAL(view.diameter_px(), seen.diameter_px, 2e-3);  // the light is spread, not lost
    CHECK(turned(view.equator_rad, *seen.equator_rad) < 0.01);
  }
}

TEST(PixelGrid, SpreadsTheEdgeOverTheWayThatTheBallMoves) {
  BallView view{.centre_px = {100.0, 100.0}, .along_px = 30.0, .across_px = 30.0};
  const auto grey = [&] {
    return std::ranges::count_if(grid.picture(), [](std::uint8_t p) { return p > 2 && p < 218; });
  };
  view.equator_rad = 0.0;
  grid.measure(view, {});
  const auto still = grey();
  grid.measure(view, {8.0, 0.0, 0.0});
  // Each row's two edges become 8 px wide.
  CHECK(grey() > still + 2 * 50 * 6);
}

TEST(PixelGrid, DrawsABrightDiscWithADarkBar) {
  const BallView view{.centre_px = {0.0, 0.0}, .along_px = 50.0, .across_px = 50.0, .equator_rad = 0.0};
  grid.measure(view, {});
  const auto& picture = grid.picture();
  LONGS_EQUAL(PixelGrid::kBall, *std::ranges::max_element(picture));
  const auto at = [&](int x, int y) {
    const int left = -grid.width() / 2, bottom = -grid.height() / 2;
    return static_cast<int>(picture[static_cast<std::size_t>((y - bottom) * grid.width() + (x - left))]);
  };
  LONGS_EQUAL(PixelGrid::kBar, at(0, 0));
  LONGS_EQUAL(PixelGrid::kBar, at(25, 0));
  LONGS_EQUAL(PixelGrid::kBall, at(40, 0));
  LONGS_EQUAL(PixelGrid::kBall, at(0, 10));
  LONGS_EQUAL(0, at(52, 0));
  LONGS_EQUAL(0, at(40, 40));
}

TEST(PixelGrid, SeesNoLineOnATinyBall) {
  const BallView view{.centre_px = {0.3, 0.0}, .along_px = 4.0, .across_px = 4.0, .equator_rad = 0.5};
  const PixelMeasurement seen = grid.measure(view, {});
  CHECK(!seen.equator_rad.has_value());
  DOUBLES_EQUAL(0.3, seen.centre_px.x, 0.02);
}
