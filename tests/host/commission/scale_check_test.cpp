#include "host/commission/scale_check.hpp"

#include <cmath>
#include <random>
#include <vector>

#include "tests/host/commission/judged.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using commission_test::fails, commission_test::is_not_told, commission_test::passes;

constexpr double kWidth_px = 2880, kHeight_px = 1840, kPxPerM = 4000.0, kDiameter_m = 0.065;

struct Wrong {
  double scale = 1.0, across = 0.0, upwards = 0.0;
};

/// Balls whose sizes have the stated noise of 0.1 px.
std::vector<reduction::Frame> frames_of(const Wrong& wrong, unsigned seed = 1, int shots = 9) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.1);
  std::vector<reduction::Frame> frames(static_cast<std::size_t>(shots));
  for (reduction::Frame& frame : frames) {
    for (int i = 0; i < 20; ++i) {
      reduction::BallImage image;
      image.leg = i < 10 ? Leg::incoming : Leg::rebound;
      image.centre_px = {150.0 + 135.0 * i, 400.0 + 110.0 * std::abs(i - 10)};
      const double x = image.centre_px.x / kWidth_px - 0.5, y = image.centre_px.y / kHeight_px - 0.5;
      image.diameter_px =
          wrong.scale * kPxPerM * kDiameter_m * std::exp(wrong.across * x + wrong.upwards * y) +
          noise(random);
      image.diameter_sd_px = 0.1;
      frame.images.push_back(image);
    }
  }
  return frames;
}

ScaleCheck check_of(const Wrong& wrong, unsigned seed = 1) {
  const auto check =
      commission::check_scale(frames_of(wrong, seed), kPxPerM, kDiameter_m, kWidth_px, kHeight_px);
  if (!check) FAIL(check.error().message.c_str());
  return *check;
}

}  // namespace

TEST_GROUP(ScaleCheck){};

TEST(ScaleCheck, FindsNothingWrongWithAGoodCamera) {
  double chi_squared = 0.0;
  constexpr unsigned kRuns = 60;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const ScaleCheck check = check_of({}, seed);
    chi_squared += std::pow((check.ratio - 1.0) / check.ratio_sd, 2.0) +
                   std::pow(check.across / check.across_sd, 2.0) +
                   std::pow(check.upwards / check.upwards_sd, 2.0);
  }
  // Of 180 degrees of freedom, 5 sd are .53; sds include .02 % that these images do not have.
  CHECK(chi_squared / (3.0 * kRuns) < 1.53);
  CHECK(chi_squared / (3.0 * kRuns) > 0.3);
}

TEST(ScaleCheck, TellsAWrongScaleFromATiltedCamera) {
  const ScaleCheck scale = check_of({.scale = 1.01});
  DOUBLES_EQUAL(1.01, scale.ratio, 5.0 * scale.ratio_sd);
  DOUBLES_EQUAL(0.0, scale.across, 5.0 * scale.across_sd);
  const ScaleCheck tilted = check_of({.across = -0.012, .upwards = 0.008});
  DOUBLES_EQUAL(-0.012, tilted.across, 5.0 * tilted.across_sd);
  DOUBLES_EQUAL(0.008, tilted.upwards, 5.0 * tilted.upwards_sd);
  DOUBLES_EQUAL(1.0, tilted.ratio, 5.0 * tilted.ratio_sd);
}

TEST(ScaleCheck, IsLessCertainWhereBallsFlyNearerAndFarther) {
  auto frames = frames_of({});
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (auto& image : frames[i].images) image.diameter_px *= i % 2 == 0 ? 1.004 : 0.996;
  const auto check = commission::check_scale(frames, kPxPerM, kDiameter_m, kWidth_px, kHeight_px);
  // .4 % from shot to shot, over the root of nine.
  DOUBLES_EQUAL(0.004 / 3.0, check->ratio_sd, 0.0004);
}

TEST(ScaleCheck, LeavesOutContactAndWantsEnoughImages) {
  auto frames = frames_of({}, 1, 1);
  for (auto& image : frames[0].images) image.leg = Leg::contact;
  const auto none = commission::check_scale(frames, kPxPerM, kDiameter_m, kWidth_px, kHeight_px);
  CHECK_EQUAL("fewer than 8 images of balls in the air", none.error().message);
}

TEST(ScaleCheck, TheBallsSizeMustFitScaleAndDiameter) {
  ScaleCheck check{1.0005, 1e-4, 0.0, 1e-4, 0.0, 1e-4, 180, 9};
  passes(judge_scale(check, 0.0015, 5e-4));
  check.ratio = 1.01;
  fails("scale_off", judge_scale(check, 0.0015, 5e-4));
  // A diameter known to .3 % cannot tell.
  is_not_told("measure the ball's diameter", judge_scale(check, 0.003, 5e-4));
  check.ratio = 1.0;
  is_not_told("measure the ball's diameter", judge_scale(check, 0.003, 5e-4));
}

TEST(ScaleCheck, TheBallsSizeMustNotChangeOverThePhotograph) {
  ScaleCheck check{1.0, 1e-4, 0.004, 1e-4, -0.004, 1e-4, 180, 9};
  passes(judge_squareness(check));
  check.upwards = 0.007;
  fails("camera_tilted", judge_squareness(check));
}
