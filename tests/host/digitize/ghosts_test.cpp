// Discs by ambient light, told from the images that the flashes made.
#include "host/digitize/outliers/ghosts.hpp"

#include <cmath>
#include <limits>

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;

constexpr double kBall_px = 100.0;

/// Its limb is lit from one side, `light` at the most.
LitDisc disc_at(double x, double light, bool certain = true) {
  LitDisc disc{{x, 0.3 * x}, kBall_px, {}, certain};
  for (std::size_t k = 0; k < disc.limb.size(); ++k)
    disc.limb[k] = static_cast<float>(light * (k < disc.limb.size() / 2 ? 1.0 : 0.4));
  return disc;
}

std::vector<int> ghosts_of(const std::vector<LitDisc>& discs) {
  std::vector<int> indices;
  for (const Ghost& ghost : find_ghosts(discs)) indices.push_back(ghost.index);
  return indices;
}

}  // namespace

TEST_GROUP(Ghosts){};

TEST(Ghosts, AreTheDimDiscsOfATrailBetweenBalls) {
  const std::vector<LitDisc> discs{disc_at(0, 0.3), disc_at(30, 0.1), disc_at(60, 0.09), disc_at(90, 0.11),
                                   disc_at(200, 0.32)};
  const auto ghosts = find_ghosts(discs);
  LONGS_EQUAL(3, ghosts.size());
  LONGS_EQUAL(3, ghosts[0].index);  // the brightest first
  DOUBLES_EQUAL(0.11 / 0.3, ghosts[0].share, 1e-6);
}

TEST(Ghosts, AreNotTheBallsThatLeaveTheLight) {
  std::vector<LitDisc> discs;
  for (int k = 0; k < 8; ++k) discs.push_back(disc_at(120.0 * k, 0.4 * std::pow(0.75, k)));
  CHECK_TRUE(ghosts_of(discs).empty());
}

TEST(Ghosts, AreNotTheBallsThatNoiseAndAnotherHide) {
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(60, 0.13)}).empty());
}

TEST(Ghosts, OnABallMayBeBrighterThanOnesApart) {
  // Two flashes light a ball at one place alike within 30 %.
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(20, 0.18)}) == std::vector<int>{1});
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(20, 0.24)}).empty());
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(120, 0.18)}).empty());
}

TEST(Ghosts, AreComparedInTheDirectionsThatBothShow) {
  // Of the ball only the bright half can be seen, of the disc only the dim one and a little of the bright one.
  LitDisc ball = disc_at(0, 0.3), disc = disc_at(60, 0.3);
  const float none = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t k = 36; k < 72; ++k) ball.limb[k] = none;
  for (std::size_t k = 0; k < 30; ++k) disc.limb[k] = none;
  CHECK_TRUE(ghosts_of({ball, disc}).empty());
  // Without a direction in common nothing is said.
  for (std::size_t k = 30; k < 36; ++k) disc.limb[k] = none;
  CHECK_TRUE(ghosts_of({ball, disc}).empty());
}

TEST(Ghosts, AreNotToldBySomethingBrightThatIsNoBall) {
  CHECK_TRUE(ghosts_of({disc_at(0, 0.9, false), disc_at(90, 0.3)}).empty());
  CHECK_TRUE(ghosts_of({}).empty());
}
