#include <cmath>

#include "common/flight/parabola.hpp"

#include <CppUTest/TestHarness.h>

using strobe::flight::gravity_mps2;
using strobe::flight::kStandardGravity_mps2;
using strobe::flight::Parabola;

TEST_GROUP(Flight){};

TEST(Flight, GravityPointsStraightDownOnALevelPlate) {
  DOUBLES_EQUAL(0.0, gravity_mps2(0.0).x(), 0.0);
  DOUBLES_EQUAL(-9.80665, gravity_mps2(0.0).y(), 0.0);
}

TEST(Flight, APlateThatRisesInTheDirectionOfTravelIsBrakedByGravity) {
  const auto g = gravity_mps2(std::asin(0.6));
  DOUBLES_EQUAL(-0.6 * kStandardGravity_mps2, g.x(), 1e-14);
  DOUBLES_EQUAL(-0.8 * kStandardGravity_mps2, g.y(), 1e-14);
}

TEST(Flight, ABallThrownUpPassesAHeightTwice) {
  // y = 1 + 3t - t²·5 with a = -10: passes 1.4 at t = 0.2 and 0.4.
  const Parabola path{{0.0, 1.0}, {2.0, 3.0}, {0.0, -10.0}};
  DOUBLES_EQUAL(0.2, *path.time_rising_through_s(1.4), 1e-15);
  DOUBLES_EQUAL(0.4, *path.time_falling_through_s(1.4), 1e-15);
  DOUBLES_EQUAL(0.4, path.position_at(0.2).x(), 1e-15);
  DOUBLES_EQUAL(1.0, path.velocity_at(0.2).y(), 1e-15);
}

TEST(Flight, AHeightAboveTheTopIsNeverReached) {
  const Parabola path{{0.0, 1.0}, {2.0, 3.0}, {0.0, -10.0}};
  CHECK_FALSE(path.time_rising_through_s(1.46).has_value());
  CHECK_FALSE(path.time_falling_through_s(1.46).has_value());
}

TEST(Flight, WithoutGravityAFallingBallNeverRises) {
  const Parabola path{{0.0, 0.5}, {16.0, -4.0}, {0.0, 0.0}};
  DOUBLES_EQUAL(0.1, *path.time_falling_through_s(0.1), 1e-16);
  CHECK_FALSE(path.time_rising_through_s(0.1).has_value());
}

TEST(Flight, TheTimeOfASmallDropKeepsItsDigitsUnderWeakGravity) {
  // drop 1e-9 m at 5 m/s: t = 2e-10 (1 + 2e-10·a/(2v)...); the textbook formula would lose 10 digits here.
  const Parabola path{{0.0, 1e-9}, {0.0, -5.0}, {0.0, -9.80665}};
  const double expected = 2e-10 * (1.0 - 9.80665 * 2e-10 / 10.0);
  DOUBLES_EQUAL(1.0, *path.time_falling_through_s(0.0) / expected, 1e-15);
}
