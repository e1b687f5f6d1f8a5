// Discs by ambient light between two flashes, and that light's level as the band between images shows it.
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "host/digitize/outliers/ambient.hpp"
#include "host/digitize/outliers/ghosts.hpp"

#include <CppUTest/TestHarness.h>

namespace {
using namespace strobe::digitize;
}  // namespace

// Discs by ambient light, told from the images that the flashes made.
namespace {

constexpr double kBall_px = 100.0;

/// Its limb is lit from one side, `light` at the most.
LitDisc disc_at(double x, double light, double log_odds = 5.0) {
  LitDisc disc{{x, 0.3 * x}, kBall_px, {}, log_odds};
  for (std::size_t k = 0; k < disc.limb.size(); ++k)
    disc.limb[k] = static_cast<float>(light * (k < disc.limb.size() / 2 ? 1.0 : 0.4));
  return disc;
}

std::vector<int> ghosts_of(const std::vector<LitDisc>& discs,
                           std::optional<double> ambient_share = std::nullopt) {
  std::vector<int> indices;
  const auto lit = compare_light(discs, ambient_share);
  for (std::size_t i = 0; i < lit.size(); ++i)
    if (lit[i].ghost()) indices.push_back(static_cast<int>(i));
  return indices;
}

}  // namespace

TEST_GROUP(Ghosts){};

TEST(Ghosts, AreTheDimDiscsOfATrailBetweenBalls) {
  const std::vector<LitDisc> discs{disc_at(0, 0.3), disc_at(30, 0.1), disc_at(60, 0.09), disc_at(90, 0.11),
                                   disc_at(200, 0.32)};
  CHECK_TRUE(ghosts_of(discs) == (std::vector<int>{1, 2, 3}));
  DOUBLES_EQUAL(0.11 / 0.3, compare_light(discs, std::nullopt)[3].share, 1e-6);
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
  // Two flashes light a ball at one place alike within 30 %, and further on the light falls off.
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(20, 0.12)}) == std::vector<int>{1});
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(20, 0.21)}).empty());
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(120, 0.12)}).empty());
}

TEST(Ghosts, AreToldFarFromTheNextBallWhereTheyHardlyLookLikeOne) {
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(600, 0.03, 0.0)}) == std::vector<int>{1});
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(600, 0.2, 0.0)}).empty());
}

TEST(Ghosts, AreComparedInTheDirectionsThatBothShow) {
  // Of the ball only the bright half can be seen, of the disc the dim one and a little of the bright one.
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
  CHECK_TRUE(ghosts_of({disc_at(0, 0.9, -2.0), disc_at(90, 0.3)}).empty());
  CHECK_TRUE(ghosts_of({}).empty());
}

TEST(Ghosts, AreAsBrightAsTheRoomIs) {
  // A third of the next ball's light, far enough from it that lamps may light it by half.
  const std::vector<LitDisc> discs{disc_at(0, 0.3), disc_at(240, 0.11, 0.0)};
  CHECK_TRUE(ghosts_of(discs, 0.3) == std::vector<int>{1});
  CHECK_TRUE(ghosts_of(discs, 0.05).empty());
  // In a dark room what is dim is a ball that lamps light less, if it looks like one at all.
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(240, 0.06, 3.0)}, 0.0).empty());
  CHECK_TRUE(ghosts_of({disc_at(0, 0.3), disc_at(240, 0.06, 3.0)}, 0.15) == std::vector<int>{1});
}

TEST(Ghosts, SayHowBrightTheOthersMayBe) {
  // Of a trail whose level is not measured two discs are told; a third is a little brighter, as what lies
  // behind it hides where its limb is.
  const std::vector<LitDisc> trail{disc_at(0, 0.3), disc_at(75, 0.13), disc_at(350, 0.11), disc_at(400, 0.3)};
  CHECK_TRUE(ghosts_of(trail) == (std::vector<int>{1, 2}));
  CHECK_TRUE(ghosts_of({trail[0], trail[1], trail[3]}).empty());
  // Faint ones say nothing of brighter ones: they may be half hidden.
  CHECK_TRUE(ghosts_of({trail[0], trail[1], disc_at(350, 0.015), trail[3]}) == std::vector<int>{2});
}

TEST(Ghosts, LeaveDoubtOfDiscsThatAreHalfAsBright) {
  const auto lit = compare_light({{disc_at(0, 0.3), disc_at(100, 0.15), disc_at(200, 0.3)}}, std::nullopt);
  CHECK_FALSE(lit[1].ghost());
  // However sure it is that this is no other thing.
  const double by_odds = 1.0 / (1.0 + std::exp(-lit[1].log_odds));
  DOUBLES_EQUAL(by_odds, probability_beside_ghosts(1.0, lit[1]), 1e-12);
  CHECK_TRUE(by_odds > 0.5 && by_odds < 0.95);
  // The other things' odds, too, as one in four: 1 / p - 1 = 1 / 3 + exp(-log_odds).
  const double by_both = 1.0 / (4.0 / 3.0 + std::exp(-lit[1].log_odds));
  DOUBLES_EQUAL(by_both, probability_beside_ghosts(0.75, lit[1]), 1e-12);
  // Nothing was brighter than the first. Flashes, 30 % from each other at most, leave a ball as bright as the
  // others three sd of ambient light's and more from it: one in a thousand.
  CHECK_EQUAL(0.9999, probability_beside_ghosts(0.9999, lit[0]));
  DOUBLES_EQUAL(0.9999, probability_beside_ghosts(0.9999, lit[2]), 1e-3);
}

TEST(Ghosts, LeaveAsMuchDoubtOfOthersThatAreAsBright) {
  const std::vector<LitDisc> discs{disc_at(0, 0.3), disc_at(100, 0.15), disc_at(500, 0.3),
                                   disc_at(600, 0.15)};
  const auto lit = compare_light(discs, std::nullopt);
  DOUBLES_EQUAL(lit[1].log_odds, lit[3].log_odds, 1e-6);
}

TEST_GROUP(AmbientLight){};

TEST(AmbientLight, IsOverBothSidesOfTheWay) {
  // Discs of 1 above their background, 3 diameters apart, a band with the same profile between them.
  constexpr float kBand = 0.2F;
  constexpr int kRadius = 20;
  std::vector<ImageDisc> discs;
  for (int i = 0; i < 4; ++i) discs.push_back({{60.0 + 120.0 * i, 100.0}, kRadius});
  std::vector<Flight> flights{{0, 1}, {1, 2}, {2, 3}};
  const auto share = [&](auto&& background) {
    Photograph picture;
    picture.intensity = cv::Mat(200, 480, CV_32F);
    for (int row = 0; row < 200; ++row)
      for (int column = 0; column < 480; ++column) {
        const double s = (row - 100.0) / kRadius;
        const double off = std::abs(column - 60.0 - 120.0 * std::round((column - 60.0) / 120.0));
        float value = background(row, column);
        if (std::hypot(off, row - 100.0) < kRadius) value += 1.0F;
        if (std::abs(s) < 1.0) value += kBand * static_cast<float>(std::sqrt(1.0 - s * s));
        picture.intensity.at<float>(row, column) = value;
      }
    return ambient_share(picture, discs, flights);
  };
  // The band lies under the images, too.
  const double of_flash = kBand / (1.0 + kBand);
  DOUBLES_EQUAL(of_flash, *share([](int, int) { return 0.1F; }), 0.1 * of_flash);
  const auto brightens_along = [](int, int column) { return 0.001F * static_cast<float>(column); };
  DOUBLES_EQUAL(of_flash, *share(brightens_along), 0.1 * of_flash);
  // Along a wall's edge the band is not seen, along that of something bright nothing is told of it.
  DOUBLES_EQUAL(0.0, *share([](int row, int) { return row < 100 ? 0.1F : 0.5F; }), 0.0);
  CHECK_FALSE(share([](int row, int) { return row < 100 ? 0.1F : 0.9F; }).has_value());
  // Two flights cannot outvote a third that holds a missed image.
  flights.pop_back();
  CHECK_FALSE(share([](int, int) { return 0.1F; }).has_value());
}
