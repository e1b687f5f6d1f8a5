// Rebound from turf against the rotation done by hand, and its limit.
#include "common/impact/closed_form/turf.hpp"

#include <cmath>
#include <numbers>

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;

namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr ball::Ball kGolf{.diameter_m = 0.0427, .mass_kg = 0.0459, .alpha = 0.4};

Motion motion(double speed_mps, double from_normal_deg, double omega_radps = 0.0) {
  return {speed_mps * std::sin(from_normal_deg * kDeg), -speed_mps * std::cos(from_normal_deg * kDeg), omega_radps};
}

}  // namespace

TEST_GROUP(Turf){};

TEST(Turf, ThePlaneTiltsInProportionToSpeedAndAngle) {
  DOUBLES_EQUAL(15.4 * kDeg, contact_plane_tilt_rad(motion(18.6, 44.4)), 1e-12);
  DOUBLES_EQUAL(15.4 / 4.0 * kDeg, contact_plane_tilt_rad(motion(9.3, 22.2)), 1e-12);
  DOUBLES_EQUAL(-15.4 * kDeg, contact_plane_tilt_rad(motion(18.6, -44.4)), 1e-12);
  DOUBLES_EQUAL(0.0, contact_plane_tilt_rad(motion(18.6, 0.0)), 0.0);
}

// On the tilted plane the ball comes at 44.4 - 15.4 = 29° to the normal, rolls off (mu .4 is more than that takes) with
// 5/7 of its speed along it and 2/7 of its backspin's, and leaves with the plane's own restitution, whatever it is.
TEST(Turf, ABallThatRollsOffDoesSoOnTheTiltedPlane) {
  const double e = 0.3, backspin = 300.0, beta = 15.4 * kDeg;
  const Motion in = motion(18.6, 44.4, backspin);
  const auto out = rigid_on_turf(kGolf, in, e, 0.6);
  CHECK(out.has_value());
  DOUBLES_EQUAL(-e * in.vy_mps, out->lift_off.vy_mps, 1e-12);
  const double along = out->lift_off.vx_mps * std::cos(beta) + out->lift_off.vy_mps * std::sin(beta);
  DOUBLES_EQUAL(5.0 / 7.0 * 18.6 * std::sin(29.0 * kDeg) - 2.0 / 7.0 * 0.02135 * backspin, along, 1e-12);
  DOUBLES_EQUAL(-along / 0.02135, out->lift_off.omega_radps, 1e-10);
}

TEST(Turf, StraightDownIsTheRigidBody) {
  const Motion in = motion(10.0, 0.0, 200.0);
  const auto out = rigid_on_turf(kGolf, in, 0.4, 0.3), level = rigid(kGolf, in, 0.4, 0.3);
  DOUBLES_EQUAL(level->lift_off.vx_mps, out->lift_off.vx_mps, 1e-12);
  DOUBLES_EQUAL(level->lift_off.omega_radps, out->lift_off.omega_radps, 1e-12);
}

TEST(Turf, MirroredMotionGivesTheMirroredRebound) {
  const auto one = rigid_on_turf(kGolf, motion(15.0, 40.0, 100.0), 0.3, 0.3);
  const auto other = rigid_on_turf(kGolf, motion(15.0, -40.0, -100.0), 0.3, 0.3);
  DOUBLES_EQUAL(one->lift_off.vx_mps, -other->lift_off.vx_mps, 1e-12);
}

// A skimming ball leaves the front of its pit upward even without restitution.
TEST(Turf, ARestitutionThatNoTiltedPlaneGivesIsRefused) {
  const auto out = rigid_on_turf(kGolf, motion(40.0, 75.0), 0.01, 0.05);
  CHECK(!out);
  CHECK(out.error() == InputError::restitution_out_of_range);
  CHECK(rigid_on_turf(kGolf, motion(10.0, 40.0), 0.3, -1.0).error() == InputError::friction_negative);
}
