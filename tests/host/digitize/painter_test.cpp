#include "tests/host/digitize/painter.hpp"

#include <cmath>
#include <numbers>

#include <CppUTest/TestHarness.h>

using strobe::testing::paint;
using strobe::testing::PaintedBall;
using strobe::testing::Painting;

namespace {

Painting evenly_lit_disc() {
  Painting painting;
  painting.width = 200;
  painting.height = 160;
  painting.background = 0.06;
  painting.flashes = 30;
  painting.bits = 16;
  painting.electrons = 0.0;
  painting.read_noise = 0.0;
  PaintedBall ball;
  ball.centre = {97.3, 71.8};
  ball.diameter_px = 80.4;
  ball.light = 0.4;
  ball.limb = 0.0;
  ball.ambient = 0.0;
  painting.balls = {ball};
  return painting;
}

}  // namespace

TEST_GROUP(Painter){};

TEST(Painter, PutsADiscOfTheDiameterWhereItsCentreIs) {
  const Painting painting = evenly_lit_disc();
  const auto photograph = paint(painting);
  cv::Mat above = photograph.intensity - 0.06;
  const double total = cv::sum(above)[0];
  double x = 0.0, y = 0.0;
  for (int row = 0; row < above.rows; ++row)
    for (int col = 0; col < above.cols; ++col) {
      const double share = above.at<float>(row, col) / total;
      x += col * share;
      y += row * share;
    }
  // A disc's edge crosses some 320 pixels, each sampled at 100 points: the area to 0.01 / sqrt(320) px each,
  // with a factor of three in hand; rounding to 16 bits is less.
  DOUBLES_EQUAL(97.3, x, 0.003);
  DOUBLES_EQUAL(71.8, y, 0.003);
  const double area = total / (0.4 - 0.06 / 30);
  DOUBLES_EQUAL(80.4, std::sqrt(4 * area / std::numbers::pi), 0.003);
}

TEST(Painter, AddsTheLightOfImagesThatOverlap) {
  Painting painting = evenly_lit_disc();
  painting.balls.push_back(painting.balls.front());
  painting.balls.back().centre.x += 40;
  const auto photograph = paint(painting);
  DOUBLES_EQUAL(0.06, photograph.intensity.at<float>(10, 10), 1e-4);
  DOUBLES_EQUAL(0.4 + 0.06 - 0.06 / 30, photograph.intensity.at<float>(72, 75), 1e-4);
  DOUBLES_EQUAL(0.8 + 0.06 - 2 * 0.06 / 30, photograph.intensity.at<float>(72, 117), 1e-4);
}

TEST(Painter, RepeatsAPictureByItsSeed) {
  Painting painting = evenly_lit_disc();
  painting.read_noise = 0.01;
  std::mt19937_64 random(3);
  painting.balls = {strobe::testing::random_ball(random, {100, 80}, 90)};
  const auto first = paint(painting), again = paint(painting);
  DOUBLES_EQUAL(0.0, cv::norm(first.intensity, again.intensity, cv::NORM_INF), 0.0);
  painting.seed = 2;
  CHECK(cv::norm(first.intensity, paint(painting).intensity, cv::NORM_INF) > 0.01);
}
