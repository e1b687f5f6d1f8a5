#include <string>
#include <vector>

#include "common/geometry/leg_classification.hpp"

#include "tests/support/string_from.hpp"

using strobe::Leg;
using namespace strobe::geometry;

namespace {

constexpr double kGravity = -9.80665;
constexpr double kVariance = 0.25e-6;  // half a millimetre

std::string word(const std::vector<Leg>& legs) {
  std::string text;
  for (const Leg leg : legs) text += leg == Leg::incoming ? 'i' : leg == Leg::contact ? 'c' : 'r';
  return text;
}

/// Lower edge of a ball at -6 m/s, 4 ms in contact, 5 m/s after; flashes every 3 ms; touchdown at time 0.
std::vector<TimedHeight> bounce(double first_flash_s, int flashes) {
  std::vector<TimedHeight> heights;
  for (int i = 0; i < flashes; ++i) {
    const double t = first_flash_s + i * 3e-3, free = t < 0 ? -6.0 * t : 5.0 * (t - 4e-3);
    const double height = t >= 0 && t <= 4e-3 ? -0.006 : free + 0.5 * kGravity * t * t;
    heights.push_back({t, height, kVariance, std::nullopt});
  }
  return heights;
}

LegAssignment find_with(const std::vector<TimedHeight>& heights, double reference_variance) {
  return classify_timed(heights, kGravity, reference_variance);
}
LegAssignment find(const std::vector<TimedHeight>& heights) { return find_with(heights, kVariance); }

}  // namespace

TEST_GROUP(TimedLegs){};

TEST(TimedLegs, FindsFlightContactAndFlight) {
  CHECK_EQUAL("iiiicrrr", word(find(bounce(-10e-3, 8)).legs));     // flashes at -1 and 2 ms
  CHECK_EQUAL("iiiiccrrr", word(find(bounce(-11.5e-3, 9)).legs));  // at 0.5 and 3.5 ms
}

TEST(TimedLegs, ABounceBetweenTwoFlashesHasNoContactImage) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  heights.erase(heights.begin() + 4);
  CHECK_EQUAL("iiiirrr", word(find(heights).legs));
}

TEST(TimedLegs, JudgesAnImageAtTheSurfaceByItsTimeNotByItsHeight) {
  // The image 0.1 ms before touchdown is 0.6 mm above the surface. Two sd of noise either way change nothing.
  for (const double noise : {-1e-3, 1e-3}) {
    std::vector<TimedHeight> before = bounce(-9.1e-3, 7);
    before[3].height_m += noise;
    CHECK_EQUAL("iiiicrr", word(find(before).legs).substr(0, 7));
    std::vector<TimedHeight> after = bounce(-8.9e-3, 7);  // 0.1 ms after touchdown: -0.6 mm if it were flight
    after[3].height_m = -0.6e-3 + noise;
    CHECK_EQUAL("iiiccrr", word(find(after).legs));
  }
}

TEST(TimedLegs, AnImagePressedIntoTheSurfaceIsInContactThoughItsTimeIsWithinTheLeg) {
  // Drag and lift of 5 m/s^2, of which the path's prediction knows nothing: over 57 ms it reaches the surface
  // 5 · 0.057^2 / 12 m = 1.4 mm too high, 0.27 ms too early. 0.1 ms before lift-off the ball is 0.5 mm deep, 35 sd.
  constexpr double kFine = 1e-10;  // 10 micrometres
  std::vector<TimedHeight> heights{{-3.1e-3, -0.01, kFine, std::nullopt},
                                   {-0.1e-3, -0.5e-3, kFine, std::nullopt}};
  for (int i = 0; i < 20; ++i) {
    const double t = 2.9e-3 + i * 3e-3;
    heights.push_back({t, 5.0 * t + 0.5 * (kGravity - 5.0) * t * t, kFine, std::nullopt});
  }
  CHECK_EQUAL("cc" + std::string(20, 'r'), word(find_with(heights, kFine).legs));
}

TEST(TimedLegs, KeepsLabels) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  heights[5].leg = Leg::contact;
  CHECK_EQUAL("iiiiccrr", word(find(heights).legs));
}

TEST(TimedLegs, LeavesOutAnOverlappingImageThatIsLabelledAirborne) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i].leg = i < 5 ? Leg::incoming : Leg::rebound;
  const LegAssignment found = find(heights);
  CHECK_EQUAL("iiiicrrr", word(found.legs));
  LONGS_EQUAL(1, found.overlaps.size());
  LONGS_EQUAL(4, found.overlaps[0]);
}

TEST(TimedLegs, AnImageInContactButWithinNoiseIsNotAnOverlap) {
  std::vector<TimedHeight> heights = bounce(-8.9e-3, 7);
  heights[3].height_m = -0.6e-3;
  for (std::size_t i = 0; i < heights.size(); ++i)
    heights[i].leg = i < 4 ? Leg::incoming : i == 4 ? Leg::contact : Leg::rebound;
  CHECK_TRUE(find(heights).overlaps.empty());
}

TEST(TimedLegs, TakesWhatThereIs) {
  CHECK_TRUE(find({}).legs.empty());
  CHECK_EQUAL("c", word(find({{0.0, -0.001, kVariance, std::nullopt}}).legs));
  const std::vector<TimedHeight> falling = bounce(-10e-3, 3);
  LONGS_EQUAL(3, find(falling).legs.size());
}

TEST(TimedLegs, KnowWhichWayGravityPulls) {
  // A slow ball, 20 ms between flashes: falling from rest at 5 cm, the next image is at 0.1 s, 4.9 cm below,
  // 1 mm above the surface. Without the fall it would be judged far above it; with the fall counted upwards, too.
  const auto slow = [](double last_s) {
    std::vector<TimedHeight> heights;
    for (const double t : {0.0, 0.03, 0.06, last_s})
      heights.push_back({t, 0.0441 + 0.5 * kGravity * t * t, 1e-8, std::nullopt});
    heights.back().height_m = 1e-5;  // within noise of the surface: only its time tells
    return heights;
  };
  // 0.0441 m are fallen in 94.8 ms.
  CHECK_EQUAL("iiii", word(find_with(slow(0.0945), 1e-8).legs));
  CHECK_EQUAL("iiic", word(find_with(slow(0.0952), 1e-8).legs));
}

TEST_GROUP(UntimedLegs) {
  using Centres = std::vector<Eigen::Vector2d>;
  static std::string legs(const Centres& centres, std::vector<std::optional<Leg>> labels = {},
                          double contact_height = 0.9) {
    labels.resize(centres.size());
    return word(classify_untimed(centres, labels, contact_height));
  }
};

TEST(UntimedLegs, ChangeAtTheLowestImage) {
  CHECK_EQUAL("", legs({}));
  CHECK_EQUAL("i", legs({{0, 2}}));
  CHECK_EQUAL("iicrr", legs({{0, 3}, {1, 2}, {2, 0.5}, {3, 2}, {4, 3}}));
  CHECK_EQUAL("iiccrr", legs({{0, 3}, {1, 2}, {2, 0.5}, {3, 0.8}, {4, 2}, {5, 3}}));
}

TEST(UntimedLegs, GiveALowestImageInTheAirToTheLegOnWhoseLineItIs) {
  CHECK_EQUAL("iiirr", legs({{0, 3}, {1, 2}, {2, 1}, {4, 1.5}, {6, 2.5}}));
  CHECK_EQUAL("iirrr", legs({{0, 3}, {1, 1.5}, {3, 1}, {4, 2}, {5, 3}}));
  CHECK_EQUAL("rrr", legs({{0, 1}, {1, 2}, {2, 3}}));
  CHECK_EQUAL("iii", legs({{0, 3}, {1, 2}, {2, 1}}));
  CHECK_EQUAL("ir", legs({{0, 1}, {1, 2}}, {Leg::incoming}));
}

TEST(UntimedLegs, KeepLabelsExceptOfImagesThatTouch) {
  CHECK_EQUAL("iiirr", legs({{0, 3}, {1, 2}, {2, 1}, {3, 0.95}, {4, 2}},
                            {std::nullopt, std::nullopt, std::nullopt, Leg::rebound, std::nullopt}));
  CHECK_EQUAL("iicrr", legs({{0, 3}, {1, 2}, {2, 0.5}, {3, 2}, {4, 3}}, {{}, {}, Leg::incoming, {}, {}}));
}

TEST(UntimedLegs, FollowEachOther) {
  CHECK_EQUAL("icccr", legs({{0, 3}, {1, 2}, {2, 1}, {3, 2}, {4, 3}},
                            {Leg::incoming, Leg::rebound, Leg::incoming, Leg::incoming, Leg::rebound}));
}
