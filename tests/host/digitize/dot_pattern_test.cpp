#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "common/attitude/attitude_spin.hpp"
#include "host/digitize/pattern/dot_pattern.hpp"
#include "tests/host/digitize/dotted_ball.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::digitize;
using namespace strobe::testing;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string error_of(std::string_view text) {
  const auto pattern = parse_dot_pattern(text, "dots.csv");
  return pattern ? std::string() : pattern.error().message;
}

DotPattern drawn() { return {drawn_pattern(20, 0.45, 4)}; }

Vector3d off(const BallAttitude& found, const Matrix3d& truth) {
  return attitude::rotation_vector_rad(found.attitude * truth.transpose());
}

}  // namespace

TEST_GROUP(DotPatterns){};

TEST(DotPatterns, AreDirectionsOrAngles) {
  const auto directions = parse_dot_pattern("# mine\n0,0,1\n1,0,0\n0, -1,0\n0.6,0,-0.8\n", "dots.csv");
  const auto angles = parse_dot_pattern("0,0\n90,0\n90,270\n143.13010235415598,0\n", "dots.csv");
  CHECK_TRUE(directions && angles);
  for (std::size_t i = 0; i < 4; ++i)
    CHECK_TRUE((directions->dots[i] - angles->dots[i]).norm() < 1e-15 * 10);  // rounding of sine and cosine
}

TEST(DotPatterns, WhatIsNoneIsOneLine) {
  CHECK_EQUAL(std::string("dots.csv: 1 dots; a pattern has 4 or more"), error_of("0,0,1\n"));
  CHECK_EQUAL(std::string("dots.csv:2: must be x,y,z or theta,phi, all rows alike"), error_of("0,0,1\n90,0\n"));
  CHECK_EQUAL(std::string("dots.csv:1: a direction of length 2 is none of length 1"), error_of("0,0,2\n"));
  CHECK_EQUAL(std::string("dots.csv:1: theta: must be from 0 to 180 degrees"), error_of("181,0\n"));
  CHECK_EQUAL(std::string("dots.csv:2: less than 5.7 degrees from another dot"), error_of("90,0\n90,5\n"));
  CHECK_TRUE(error_of("x,y,z\n").starts_with("dots.csv:1:"));
}

TEST_GROUP(DotAttitudes){};

// A ball of 100 px, white noise of 1 %, everything found by the digitizer itself. `strobe-bench attitude` measured
// .13 degrees rms over many; a single one may be off by four times that, and no attitude may be another.
TEST(DotAttitudes, AreFoundOnRenderedBallsWhereverTheDotsAre) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> share;
  int found = 0;
  double sum = 0.0;
  for (int k = 0; k < 8; ++k) {
    DottedBall ball{.dots = drawn().dots};
    ball.attitude = attitude_from(share(random), share(random), share(random));
    ball.off_px = {share(random), share(random)};
    ball.seed = static_cast<std::uint64_t>(k);
    const Photograph photograph = photograph_of(ball);
    const auto outline = only_ball(photograph);
    CHECK_TRUE(outline.has_value());
    const auto one = measure_attitude(photograph, PlaneMap::uncalibrated(photograph.height()), *outline, drawn(), 1e-3);
    if (!one) continue;
    ++found;
    CHECK_TRUE(off(*one, ball.attitude).norm() < 0.6 * kDegree);
    sum += off(*one, ball.attitude).dot(one->covariance_rad2.inverse() * off(*one, ball.attitude)) / 3.0;
  }
  CHECK_TRUE(found >= 6);
  // 3·8 squared standardized errors: 1 ± .29; 4 sd.
  CHECK_TRUE(sum / found < 2.2);
}

TEST(DotAttitudes, ABallOfAnotherPatternOrWithoutDotsHasNone) {
  DottedBall ball{.dots = drawn_pattern(20, 0.45, 99)};
  const PlaneMap map = PlaneMap::uncalibrated(photograph_of(ball).height());
  for (int k = 0; k < 5; ++k) {
    ball.attitude = attitude_from(0.15 * k, 0.3, 0.13 * k);
    if (k == 4) ball.dots.clear();
    const Photograph photograph = photograph_of(ball);
    const auto outline = only_ball(photograph);
    CHECK_TRUE(outline.has_value());
    const auto found = measure_attitude(photograph, map, *outline, drawn(), 1e-3);
    CHECK_FALSE(found.has_value());
    CHECK_TRUE(found.error().message.starts_with("dotted ball: "));
  }
}

// The dots of a cube's corners: 24 attitudes look alike.
TEST(DotAttitudes, OfASymmetricPatternAreSaidToBeAmbiguous) {
  DotPattern cube;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) cube.dots.push_back(Vector3d(x, y, z).normalized());
  std::vector<SeenDot> seen;
  const Matrix3d attitude = attitude_from(0.4, 0.7, 0.2);
  for (const Vector3d& dot : cube.dots)
    if (const Vector3d n = attitude * dot; n.z() > 0.0) seen.push_back({n.head<2>(), 1e-6 * Eigen::Matrix2d::Identity(), 0.5});
  const auto found = match_dots(seen, cube, {});
  CHECK_FALSE(found.has_value());
  CHECK_TRUE(found.error().message.find("another attitude") != std::string::npos);
}
