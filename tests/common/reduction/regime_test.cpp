// Whether the ball slid or gripped.
#include <numbers>

#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

TEST_GROUP(Regime21){};

TEST(Regime21, OnlyTheThreeShallowSetsSlideThroughout) {
  // Known from the thesis's measured means: zero -17, back -17 and back -22 slide, the others grip.
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = 0.02e-3;
  setup.equator_sd_rad = 0.001;
  for (const Bounce& b : test::thesis_bounces()) {
    test::Random random(1);
    const Readout r = reduced(test::photograph(b, setup, random));
    const bool slides = b.label == "zero_17" || b.label == "back_17" || b.label == "back_22";
    CHECK_TRUE_TEXT(r.regime == (slides ? Regime::slides : Regime::grips), b.label.c_str());
  }
}

TEST(Regime21, TheBallsInertiaDecidesWhatRollingNeeds) {
  // Slip 15 - 3.25 = 11.75 m/s, of which alpha / (1 + alpha), 0.355 at 0.55, must go to roll: 4.17 of the 6
  // that vx lost, so it gripped.
  Frame frame = straight_frame();
  frame.images[1].equator_rad = 0.1 - 0.2 + std::numbers::pi;
  CHECK_TRUE(reduced(frame).regime == Regime::grips);
  // With backspin the slip is 18.25 m/s.
  frame.images[1].equator_rad = 0.1 + 0.2;
  frame.ball_alpha = 0.3;
  CHECK_TRUE(reduced(frame).regime == Regime::grips);  // needs 4.21
  frame.ball_alpha = 2.0 / 3.0;
  CHECK_TRUE(reduced(frame).regime == Regime::slides);  // needs 7.3
}

TEST(Regime21, WithinTwoSdItIsUnclear) {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  const Bounce b = test::thesis_bounces().front();  // 0.95 m/s short of rolling
  setup.centre_sd_m = 5e-3;
  test::Random random(1);
  CHECK_TRUE(reduced(test::photograph(b, setup, random)).regime == Regime::unclear);
}
