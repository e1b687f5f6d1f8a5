#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/physics/thesis_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using ball::Ball;
using strobe::testing::thesis_data;

namespace {

const Ball kThinShell{.alpha = 2.0 / 3.0};
const Ball kMeasured{.alpha = 0.55};
constexpr double kRadius = ball::kThesisDiameter_m / 2.0;

Motion touchdown_of(const thesis::Condition& c) {
  return {c.vx_td_mps.mean, c.vy_td_mps.mean, c.omega_td_radps.mean};
}

InputError error_of(const std::function<void(Ball&, Motion&, Coefficients&)>& change) {
  Ball b;
  Motion m{15.0, -7.0, 10.0};
  Coefficients c = kFittedToThesis;
  change(b, m, c);
  return grip(b, m, c).error();
}

}  // namespace

TEST_GROUP(Rebound){};

TEST(Rebound, SlidingThroughoutLosesMuTimesTheNormalImpulse) {
  const auto r = rigid(kThinShell, {15.0, -5.0, 0.0}, 0.8, 0.3);
  CHECK_EQUAL(Regime::slides, r->regime);
  DOUBLES_EQUAL(15.0 - 0.3 * 9.0, r->lift_off.vx_mps, 1e-14);
  DOUBLES_EQUAL(4.0, r->lift_off.vy_mps, 0.0);
  DOUBLES_EQUAL(-0.3 * 9.0 / (2.0 / 3.0 * kRadius), r->lift_off.omega_radps, 1e-12);
  DOUBLES_EQUAL(0.3, r->impulse_ratio, 1e-15);
}

TEST(Rebound, RollingOffFollowsTheThesissEquations14And15) {
  const double omega = 40.0;
  const auto r = rigid(kThinShell, {10.0, -12.0, omega}, 0.7, 0.6);
  CHECK_EQUAL(Regime::grips, r->regime);
  const double vx = (3.0 * 10.0 - 2.0 * kRadius * omega) / 5.0;
  DOUBLES_EQUAL(vx, r->lift_off.vx_mps, 1e-14);
  DOUBLES_EQUAL(-vx / kRadius, r->lift_off.omega_radps, 1e-11);
  DOUBLES_EQUAL(0.0, r->slip_lo_mps, 1e-14);
}

TEST(Rebound, TopspinFasterThanRollingIsDrivenForward) {
  const auto r = rigid(kThinShell, {5.0, -8.0, -400.0}, 0.75, 0.1);
  CHECK_EQUAL(Regime::slides, r->regime);
  DOUBLES_EQUAL(5.0 + 0.1 * 14.0, r->lift_off.vx_mps, 1e-14);
  CHECK(r->lift_off.omega_radps > -400.0);
  DOUBLES_EQUAL(-0.1, r->impulse_ratio, 1e-15);
}

// The thesis's slide/roll table put right for signed slip. Measured slip at lift-off tells which sets slid.
TEST(Rebound, ClassifiesAll21SetsAsMeasured) {
  std::set<std::string> predicted, measured;
  for (const auto& c : thesis_data(thesis::Version::corrected).conditions) {
    const auto r = rigid(kThinShell, touchdown_of(c), c.e.mean, 0.55);
    if (r->regime == Regime::slides) predicted.insert(c.name());
    const double slip_sd = std::hypot(c.vx_lo_mps.sd, kRadius * c.omega_lo_radps.sd);
    if (c.vx_lo_mps.mean + kRadius * c.omega_lo_radps.mean > 3.0 * slip_sd) measured.insert(c.name());
  }
  CHECK_EQUAL((std::set<std::string>{"zero_17", "back_17", "back_22"}), predicted);
  CHECK_EQUAL(measured, predicted);
}

TEST(Rebound, ASpinlessDropGoesStraightUpAgain) {
  const auto r = grip(kMeasured, {0.0, -17.0, 0.0}, kFittedToThesis);
  DOUBLES_EQUAL(0.0, r->lift_off.vx_mps, 0.0);
  DOUBLES_EQUAL(0.0, r->lift_off.omega_radps, 0.0);
}

TEST(Rebound, ARollingBallIsSlowedByTheOffsetAndNotByFrictionAlone) {
  const Motion rolling{10.0, -3.0, -10.0 / kRadius};
  const auto without = grip(kMeasured, rolling, {.e = 0.8, .mu = 0.5});
  DOUBLES_EQUAL(10.0, without->lift_off.vx_mps, 1e-13);
  const auto with = grip(kMeasured, rolling, {.e = 0.8, .mu = 0.5, .offset_m = 0.003});
  CHECK(with->lift_off.vx_mps < 10.0);
  CHECK(std::abs(with->lift_off.omega_radps) < 10.0 / kRadius);
  DOUBLES_EQUAL(0.0, with->slip_lo_mps, 1e-13);
}

TEST(Rebound, AnOffsetCannotSpinABallUpOnAFrictionlessSurface) {
  const auto r = grip(kMeasured, {12.0, -10.0, 0.0}, {.e = 1.0, .mu = 0.0, .offset_m = 0.003});
  DOUBLES_EQUAL(0.0, r->lift_off.omega_radps, 1e-12);
  DOUBLES_EQUAL(0.0, r->offset_m, 1e-15);
  DOUBLES_EQUAL(12.0, r->lift_off.vx_mps, 0.0);
}

TEST(Rebound, RefusesInputsOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using B = Ball&;
  using M = Motion&;
  using C = Coefficients&;
  CHECK(error_of([nan](B, M m, C) { m.omega_radps = nan; }) == InputError::not_finite);
  CHECK(error_of([](B, M m, C) { m.vx_mps = INFINITY; }) == InputError::not_finite);
  CHECK(error_of([nan](B, M, C c) { c.e = nan; }) == InputError::not_finite);
  CHECK(error_of([](B, M m, C) { m.vy_mps = 0.0; }) == InputError::not_approaching);
  CHECK(error_of([](B, M m, C) { m.vy_mps = 7.0; }) == InputError::not_approaching);
  CHECK(error_of([](B, M, C c) { c.e = 1.0001; }) == InputError::restitution_out_of_range);
  CHECK(error_of([](B, M, C c) { c.e = -0.0001; }) == InputError::restitution_out_of_range);
  CHECK(error_of([](B, M, C c) { c.mu = -0.1; }) == InputError::friction_negative);
  CHECK(error_of([](B, M, C c) { c.e_x = 1.5; }) == InputError::tangential_restitution_out_of_range);
  CHECK(error_of([](B, M, C c) { c.offset_m = -0.001; }) == InputError::offset_out_of_range);
  CHECK(error_of([](B, M, C c) { c.offset_m = 0.04; }) == InputError::offset_out_of_range);
  CHECK(error_of([](B, M, C c) { c.offset_reference_mps = 0.0; }) == InputError::offset_out_of_range);
  CHECK(error_of([](B b, M, C) { b.diameter_m = 0.0; }) == InputError::ball_out_of_range);
  CHECK(error_of([](B b, M, C) { b.alpha = 0.9; }) == InputError::ball_out_of_range);
}
