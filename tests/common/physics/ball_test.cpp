#include <limits>

#include "common/ball/ball.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::ball;

TEST_GROUP(BallModel){};

TEST(BallModel, AThinShellAtTheMeanRadiusHasAnAlphaOf0508) {
  const double inertia = thin_shell_inertia_kgm2(kThesisMass_kg, kShellMeanRadius_m);
  DOUBLES_EQUAL(3.10e-5, inertia, 0.005e-5);  // three printed digits
  const double radius = kThesisDiameter_m / 2.0;
  DOUBLES_EQUAL(0.508, inertia / (kThesisMass_kg * radius * radius), 0.0005);
}

TEST(BallModel, AThickShellHasAFewMilligramSquareMetresMoreThanTheThinOne) {
  DOUBLES_EQUAL(3.11e-5, *thick_shell_inertia_kgm2(kThesisMass_kg, kShellOuterRadius_m, kShellInnerRadius_m),
                0.005e-5);
}

TEST(BallModel, AThickShellOfNoThicknessIsAThinOne) {
  DOUBLES_EQUAL(1.0, *thick_shell_inertia_kgm2(0.057, 0.03, 0.03) / thin_shell_inertia_kgm2(0.057, 0.03),
                1e-15);
}

TEST(BallModel, AThickShellWithoutAHoleIsASolidSphere) {
  DOUBLES_EQUAL(0.4 * 0.057 * 0.03 * 0.03, *thick_shell_inertia_kgm2(0.057, 0.03, 0.0), 1e-20);
}

TEST(BallModel, RefusesSizesMassesAndInertiasThatNoBallHas) {
  CHECK(check(Ball{}).has_value());
  CHECK_FALSE(check(Ball{.diameter_m = 0.0}).has_value());
  CHECK_FALSE(check(Ball{.mass_kg = -0.05}).has_value());
  CHECK_FALSE(check(Ball{.alpha = 0.0}).has_value());
  CHECK_FALSE(check(Ball{.alpha = 0.7}).has_value());
  CHECK_FALSE(check(Ball{.diameter_m = std::numeric_limits<double>::quiet_NaN()}).has_value());
}
