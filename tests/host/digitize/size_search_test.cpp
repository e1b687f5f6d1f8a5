// The ball's size found on photographs of unknown or wrongly stated scale.
#include "host/digitize/candidates/size_search.hpp"

#include <random>

#include "host/digitize/candidates/size_decision.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;
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
      const auto photograph = painter::paint(flight(diameter, 0.0, seed));
      const auto size =
          most_voted_size(find_whole_circles(photograph), PlaneMap::uncalibrated(photograph.height()));
      CHECK_TRUE(size.has_value());
      DOUBLES_EQUAL(diameter, size->diameter_px, 0.03 * diameter);  // as promised
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
