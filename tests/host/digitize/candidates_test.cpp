#include <cstdio>
#include <optional>
#include <random>
#include <vector>

#include "host/digitize/candidates/candidates.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::digitize;
using namespace strobe::testing;

namespace {

constexpr double kDiameter = 64.0;
const SearchRange kRange{0.46 * kDiameter, 0.54 * kDiameter, 0.2};

/// Images of one ball, each 0.7 of its diameter further to the right: up to three lie over each other.
Painting flight(std::uint64_t seed, double light) {
  std::mt19937_64 random(seed);
  Painting painting;
  painting.width = 420;
  painting.height = 160;
  painting.background *= light;
  painting.seed = seed;
  painting.bits = 12;
  auto ball = random_ball(random, {}, kDiameter);
  ball.light *= light;
  for (int i = 0; i < 7; ++i)
    painting.balls.push_back(next_image(ball, {50.3 + 0.7 * kDiameter * i, 50.7 + 9.0 * i}, 0.2 * i));
  return painting;
}

std::size_t count_near(const std::vector<Candidate>& candidates, cv::Point2d centre, double within) {
  std::size_t count = 0;
  for (const auto& candidate : candidates)
    count += cv::norm(candidate.centre_image - centre) < within ? 1 : 0;
  return count;
}

}  // namespace

TEST_GROUP(Candidates){};

TEST(Candidates, EachOfManyOverlappingImagesIsFoundOnceBrightOrFaint) {
  for (const double light : {1.0, 0.125}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const Painting painting = flight(seed, light);
      const auto photograph = paint(painting);
      for (const Effort effort : {Effort::fast, Effort::standard}) {
        const auto found = find_candidates(photograph, kRange, effort);
        for (const auto& ball : painting.balls) {
          // The promise is a pixel, and two for fast, at a ball of 260 px.
          const std::size_t count = count_near(found, ball.centre, 2.0);
          if (count != 1)
            std::printf("seed %d, light %g, %.0f %.0f\n", static_cast<int>(seed), light, ball.centre.x,
                        ball.centre.y);
          CHECK_EQUAL(1U, count);
        }
      }
    }
  }
}

TEST(Candidates, WhatIsMoreLikeABallComesFirst) {
  const auto found = find_candidates(paint(flight(5, 1.0)), kRange, Effort::standard);
  CHECK_TRUE(found.size() >= 7);
  for (std::size_t i = 1; i < found.size(); ++i) CHECK_TRUE(found[i - 1].score >= found[i].score);
}

TEST(Candidates, NothingLooksMuchLikeABallOnAnEmptyPhotographOrAlongAPlate) {
  Painting painting;
  painting.width = 300;
  painting.height = 200;
  for (const std::optional<double> plate_row : {std::optional<double>(), std::optional(140.0)}) {
    painting.plate_row = plate_row;
    for (const auto& candidate : find_candidates(paint(painting), kRange, Effort::standard))
      CHECK_TRUE(candidate.score < 0.35);
  }
}

TEST(Candidates, RadiiThatNoBallCanHaveThereFindNone) {
  const auto photograph = paint(flight(6, 1.0));
  for (const SearchRange range : {SearchRange{2.0, 3.0}, SearchRange{30.0, 20.0}, SearchRange{400.0, 500.0}})
    CHECK_TRUE(find_candidates(photograph, range, Effort::fast).empty());
}

TEST(Candidates, ABallCutOffByTheBorderIsFoundByWhatIsSeen) {
  std::mt19937_64 random(3);
  Painting painting;
  painting.width = 200;
  painting.height = 160;
  painting.balls = {random_ball(random, {5.0, 80.0}, kDiameter)};
  const auto found = find_candidates(paint(painting), kRange, Effort::standard);
  CHECK_EQUAL(1U, count_near(found, {5.0, 80.0}, 2.0));
}

// The ball's size found on photographs of unknown or wrongly stated scale.
namespace {

namespace painter = strobe::testing;

/// Five images of a ball whose path comes nearer: the last is larger by `growth`.
painter::Painting flight(double diameter_px, double growth, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  painter::Painting painting;
  painting.width = static_cast<int>(6.0 * diameter_px);
  painting.height = static_cast<int>(3.0 * diameter_px);
  painting.seed = seed;
  painting.bits = 12;
  painter::PaintedBall look = painter::random_ball(random, {}, diameter_px);
  for (int k = 0; k < 5; ++k) {
    look = painter::next_image(look, {(0.8 + 1.1 * k) * diameter_px, (0.9 + 0.25 * k) * diameter_px}, 0.3);
    look.diameter_px = diameter_px * (1.0 + growth * (k - 2) / 4.0);
    painting.balls.push_back(look);
  }
  return painting;
}

SizeDecision decided(const Photograph& photograph, std::optional<double> diameter_px) {
  return decide_size(photograph, PlaneMap::uncalibrated(photograph.height()), {diameter_px, 0.08},
                     Effort::standard);
}

}  // namespace

TEST_GROUP(SizeSearch){};

TEST(SizeSearch, FindsTheSizeOfBallsSmallAndLarge) {
  for (const double diameter : {30.0, 75.0, 190.0}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const auto decision = decided(painter::paint(flight(diameter, 0.0, seed)), std::nullopt);
      CHECK_TRUE(decision.diameter_px.has_value());
      DOUBLES_EQUAL(diameter, *decision.diameter_px, 0.03 * diameter);  // a coarse radius is good to 3 %
    }
  }
}

TEST(SizeSearch, WithoutASizeTheRangeHoldsAllBallsOfAPathThatComesNearer) {
  const auto painting = flight(75.0, 0.18, 3);
  const auto decision = decided(painter::paint(painting), std::nullopt);
  CHECK_TRUE(decision.diameter_px.has_value());
  for (const auto& ball : painting.balls)
    CHECK_TRUE(ball.diameter_px > decision.least_px && ball.diameter_px < decision.most_px);
}

TEST(SizeSearch, TellsNoSizeOfAnEmptyPhotograph) {
  painter::Painting painting;
  painting.plate_row = 300.5;
  const auto decision = decided(painter::paint(painting), std::nullopt);
  CHECK_FALSE(decision.diameter_px.has_value());
  LONGS_EQUAL(0, decision.candidates.size());
}

TEST(SizeSearch, ASizeThatIsRightIsTakenAsItIs) {
  const auto decision = decided(painter::paint(flight(75.0, 0.0, 4)), 75.0);
  DOUBLES_EQUAL(75.0, *decision.diameter_px, 0);
  CHECK_FALSE(decision.contradicted_by_px.has_value());
}

TEST(SizeSearch, ASizeOffByTenPercentIsSetRight) {
  for (const double factor : {0.9, 1.1}) {
    const auto decision = decided(painter::paint(flight(75.0, 0.0, 5)), 75.0 * factor);
    DOUBLES_EQUAL(75.0, *decision.diameter_px, 0.03 * 75.0);
    CHECK_TRUE(decision.least_px < 75.0 && decision.most_px > 75.0);
    CHECK_FALSE(decision.contradicted_by_px.has_value());
  }
}

TEST(SizeSearch, ASizeThatIsWrongByAThirdOrFarMoreIsContradicted) {
  const auto photograph = painter::paint(flight(75.0, 0.0, 6));
  for (const double factor : {0.45, 0.7, 1.3, 2.5}) {
    const auto decision = decided(photograph, 75.0 * factor);
    CHECK_TRUE(decision.contradicted_by_px.has_value());
    DOUBLES_EQUAL(75.0, *decision.contradicted_by_px, 0.03 * 75.0);
    LONGS_EQUAL(0, decision.candidates.size());
  }
}
