#include "host/digitize/candidates/candidates.hpp"

#include <cstdio>
#include <optional>
#include <random>
#include <vector>

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
