// The size that the images of one ball agree on, against sizes that are known.
#include "host/digitize/outliers/ball_size.hpp"

#include <array>
#include <cmath>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;

Outline ball_at(double x, double diameter, double sd = 0.1) {
  Outline outline;
  outline.centre = {x, 400.0};
  outline.diameter = diameter;
  outline.covariance = cv::Matx33d::eye() * (sd * sd);
  return outline;
}

/// Seven balls 300 px apart, the diameter growing by `slope` per px of x.
std::vector<Outline> row(double slope) {
  std::vector<Outline> outlines;
  for (int k = 0; k < 7; ++k) outlines.push_back(ball_at(100.0 + 300.0 * k, 260.0 + slope * 300.0 * k));
  return outlines;
}

}  // namespace

TEST_GROUP(BallSize){};

TEST(BallSize, IsTheMedianDiameterWhateverOneOutlierIs) {
  auto outlines = row(0.0);
  outlines[2].diameter = 300.0;
  const SizeModel size = fit_size_model(outlines);
  DOUBLES_EQUAL(260.0, size.at(100.0), 1e-9);
  DOUBLES_EQUAL(260.0, size.at(1900.0), 1e-9);
}

TEST(BallSize, FollowsASteadyChangeAcrossThePhotographDespiteAnOutlier) {
  auto outlines = row(-0.004);
  outlines[4].diameter += 20.0;
  const SizeModel size = fit_size_model(outlines);
  for (const int k : {0, 3, 6}) DOUBLES_EQUAL(260.0 - 1.2 * k, size.at(100.0 + 300.0 * k), 1e-9);
}

TEST(BallSize, OfFewBallsHasNoSlope) {
  const std::vector<Outline> few{ball_at(100.0, 258.0), ball_at(700.0, 260.0), ball_at(1300.0, 262.0),
                                 ball_at(1900.0, 264.0)};
  const SizeModel size = fit_size_model(few);
  DOUBLES_EQUAL(0.0, size.slope, 0.0);
  DOUBLES_EQUAL(261.0, size.diameter, 1e-9);
}

TEST(BallSize, HasTheSdOfAMedian) {
  // Alike: each outline's own sd. A median of n normal errors has sqrt(pi/2) = 1.2533 of the mean's sd.
  const SizeModel alike = fit_size_model(row(0.0));
  DOUBLES_EQUAL(0.1 * std::sqrt(M_PI / 2.0) / std::sqrt(7.0), alike.sd, 1e-3 * alike.sd + 2e-4);
  // Differences beyond that: by the median deviation, 1.4826 times which is a normal distribution's sd.
  auto apart = row(0.0);
  const std::array off{-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0};
  const std::array shuffle{3, 0, 6, 2, 5, 1, 4};  // no trend along x
  for (std::size_t k = 0; k < off.size(); ++k) apart[static_cast<std::size_t>(shuffle[k])].diameter += off[k];
  DOUBLES_EQUAL(1.4826 * 2.0 * std::sqrt(M_PI / 2.0) / std::sqrt(7.0), fit_size_model(apart).sd, 0.01);
}

TEST(BallSize, ThatDiffersFromBallToBallHasASpreadBesideTheOutlinesOwnSd) {
  DOUBLES_EQUAL(0.0, fit_size_model(row(0.0)).spread, 0.0);
  // Where the path comes nearer and goes away again: no slope, and a median deviation of 8 px.
  auto bent = row(0.0);
  const std::array more{-12.0, -8.0, 0.0, 12.0, 8.0, 0.0, -8.0};
  for (std::size_t k = 0; k < more.size(); ++k) bent[k].diameter += more[k];
  const SizeModel size = fit_size_model(bent);
  DOUBLES_EQUAL(1.4826 * 8.0, size.spread, 0.01);
  for (const Outline& outline : bent) CHECK_FALSE(has_wrong_size(outline, size));
}

TEST(BallSize, IsWrongBeyondThreePerCentOrFiveSd) {
  SizeModel size{260.0, 0.0, 0.3};
  CHECK_FALSE(has_wrong_size(ball_at(0.0, 260.0 * 1.029), size));
  CHECK_TRUE(has_wrong_size(ball_at(0.0, 260.0 * 1.031), size));
  CHECK_TRUE(has_wrong_size(ball_at(0.0, 260.0 * 0.969), size));
  // sd 4 of the outline and 3 of the size: together 5, so that 25 px are allowed.
  size.sd = 3.0;
  CHECK_FALSE(has_wrong_size(ball_at(0.0, 260.0 + 24.5, 4.0), size));
  CHECK_TRUE(has_wrong_size(ball_at(0.0, 260.0 + 25.5, 4.0), size));
  CHECK_TRUE(has_wrong_size(ball_at(0.0, 260.0 - 25.5, 4.0), size));
}
