// Finding the legs of a bounce among its images.
#include <string>
#include <vector>

#include "common/reduction/legs.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::reduction;

namespace {

constexpr double kGravity = -9.80665;
constexpr double kVariance = 0.25e-6;  // half a millimetre

std::string word(const std::vector<Leg>& legs) {
  std::string text;
  for (const Leg leg : legs) text += leg == Leg::incoming ? 'i' : leg == Leg::contact ? 'c' : 'r';
  return text;
}

/// Lower edge of a ball at -6 m/s, 4 ms in contact, 5 m/s after; flashes every 3 ms; touchdown at time 0.
std::vector<Height> bounce(double first_flash_s, int flashes) {
  std::vector<Height> heights;
  for (int i = 0; i < flashes; ++i) {
    const double t = first_flash_s + i * 3e-3;
    const double free = t < 0 ? -6.0 * t : 5.0 * (t - 4e-3);
    const double height = t >= 0 && t <= 4e-3 ? -0.006 : free + 0.5 * kGravity * t * t;
    heights.push_back({t, height, kVariance, std::nullopt});
  }
  return heights;
}

LegAssignment find(const std::vector<Height>& heights) { return classify_legs(heights, kGravity, kVariance); }

}  // namespace

TEST_GROUP(LegFinder){};

TEST(LegFinder, FindsFlightContactAndFlight) {
  STRCMP_EQUAL("iiiicrrr", word(find(bounce(-10e-3, 8)).legs).c_str());     // flashes at -1 and 2 ms
  STRCMP_EQUAL("iiiiccrrr", word(find(bounce(-11.5e-3, 9)).legs).c_str());  // at 0.5 and 3.5 ms
}

TEST(LegFinder, ABounceBetweenTwoFlashesHasNoContactImage) {
  std::vector<Height> heights = bounce(-10e-3, 8);
  heights.erase(heights.begin() + 4);
  STRCMP_EQUAL("iiiirrr", word(find(heights).legs).c_str());
}

TEST(LegFinder, JudgesAnImageAtTheSurfaceByItsTimeNotByItsHeight) {
  // The image 0.1 ms before touchdown is 0.6 mm above the surface. Two sd of noise either way change nothing.
  for (const double noise : {-1e-3, 1e-3}) {
    std::vector<Height> before = bounce(-9.1e-3, 7);
    before[3].height_m += noise;
    STRCMP_EQUAL("iiiicrr", word(find(before).legs).substr(0, 7).c_str());
    std::vector<Height> after = bounce(-8.9e-3, 7);  // 0.1 ms after touchdown: -0.6 mm if it were flight
    after[3].height_m = -0.6e-3 + noise;
    STRCMP_EQUAL("iiiccrr", word(find(after).legs).c_str());
  }
}

TEST(LegFinder, KeepsLabels) {
  std::vector<Height> heights = bounce(-10e-3, 8);
  heights[5].leg = Leg::contact;
  STRCMP_EQUAL("iiiiccrr", word(find(heights).legs).c_str());
}

TEST(LegFinder, LeavesOutAnOverlappingImageThatIsLabelledAirborne) {
  std::vector<Height> heights = bounce(-10e-3, 8);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i].leg = i < 5 ? Leg::incoming : Leg::rebound;
  const LegAssignment found = find(heights);
  STRCMP_EQUAL("iiiicrrr", word(found.legs).c_str());
  LONGS_EQUAL(1, found.overlaps.size());
  LONGS_EQUAL(4, found.overlaps[0]);
}

TEST(LegFinder, AnImageInContactButWithinNoiseIsNotAnOverlap) {
  std::vector<Height> heights = bounce(-8.9e-3, 7);
  heights[3].height_m = -0.6e-3;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    heights[i].leg = i < 4 ? Leg::incoming : i == 4 ? Leg::contact : Leg::rebound;
  }
  CHECK_TRUE(find(heights).overlaps.empty());
}

TEST(LegFinder, TakesWhatThereIs) {
  CHECK_TRUE(find({}).legs.empty());
  STRCMP_EQUAL("c", word(find({{0.0, -0.001, kVariance, std::nullopt}}).legs).c_str());
  const std::vector<Height> falling = bounce(-10e-3, 3);
  LONGS_EQUAL(3, find(falling).legs.size());
}
