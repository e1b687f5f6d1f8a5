// Advice on exposure against light that is added up by hand.
#include "host/design/exposure.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace strobe::host;

TEST_GROUP(Exposure){};

TEST(Exposure, OfNothingMeasuredIsNotKnown) {
  CHECK_FALSE(exposure_advice({}, 1).has_value());
  CHECK_FALSE(exposure_advice(PhotographedLight{0.1, 0.2, {}}, 1).has_value());  // darker than the dark
  CHECK_FALSE(exposure_advice(PhotographedLight{0.5, 0.0, {}}, 0).has_value());
}

TEST(Exposure, OpensUntilTheOverlapsAreAsBrightAsMayBe) {
  // 0.1 a flash; two overlap: 0.2, and 0.8 is two stops more.
  const auto advice = exposure_advice(PhotographedLight{0.1, 0.0, {}}, 2);
  DOUBLES_EQUAL(2.0, advice->stops, 0.0);
  LONGS_EQUAL(10, advice->images_before_clip);
  STRCMP_EQUAL("open by 2 stops: one image is then at 40 % of white, and 2 may overlap", advice->words.c_str());
  DOUBLES_EQUAL(1.0, exposure_advice(PhotographedLight{0.2, 0.0, {}}, 2)->stops, 0.0);
  STRCMP_CONTAINS("open by 1 stop:", exposure_advice(PhotographedLight{0.2, 0.0, {}}, 2)->words.c_str());
}

TEST(Exposure, ClosesWhereOverlapsWouldClipByHalfStopsRoundedDown) {
  // 0.3 less 0.1 of dark is 0.2 a flash; five need (0.8 - 0.1)/5 = 0.14, 0.51 stops less: a whole one.
  const auto five = exposure_advice(PhotographedLight{0.3, 0.1, {}}, 5);
  DOUBLES_EQUAL(-1.0, five->stops, 0.0);
  LONGS_EQUAL(4, five->images_before_clip);  // 0.1 + 4·0.2 = 0.9
  const auto four = exposure_advice(PhotographedLight{0.3, 0.1, {}}, 4);
  DOUBLES_EQUAL(-0.5, four->stops, 0.0);  // 0.175 wanted
  STRCMP_CONTAINS("close by 0.5 stops:", four->words.c_str());
}

TEST(Exposure, NeverDarkerThanNoiseAllowsAndSaysWhatClipsThen) {
  const auto advice = exposure_advice(PhotographedLight{0.2, 0.0, {}}, 30);
  DOUBLES_EQUAL(-1.0, advice->stops, 0.0);
  STRCMP_EQUAL(
      "close by 1 stop: one image is then at 10 % of white, and clips where more than 10 of 30 overlap: use a longer "
      "period",
      advice->words.c_str());
}

TEST(Exposure, NumbersThatAreNoLightAreUndoneFirst) {
  // Numbers as the root of light: 0.5 is a quarter of the light, 0.1 a hundredth.
  const auto advice = exposure_advice(PhotographedLight{0.5, 0.1, 0.5}, 1);
  DOUBLES_EQUAL(0.24, advice->image_light, 1e-12);
  DOUBLES_EQUAL(0.01, advice->dark_light, 1e-12);
  DOUBLES_EQUAL(1.5, advice->stops, 0.0);  // 0.79/0.24 = 2^1.72
}

TEST(Exposure, ASaturatedImageTellsOnlyThatThereIsTooMuchLight) {
  const auto advice = exposure_advice(PhotographedLight{1.0, 0.0, {}}, 3);
  CHECK_TRUE(advice->is_clipped);
  LONGS_EQUAL(0, advice->images_before_clip);
  STRCMP_EQUAL("close by 2 stops at least, and photograph again: one image saturates", advice->words.c_str());
}
