#include <cmath>
#include <functional>
#include <limits>
#include <rapidcheck.h>
#include <set>
#include <string>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/physics/thesis_folder.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

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

// Properties that hold for every impact, on random ones. A failure prints the seed that repeats it
// (RC_PARAMS).
using strobe::Regime;
using strobe::ball::Ball;

namespace {

struct Case {
  Ball ball;
  Motion in;
  Coefficients c;
};

double between(double low, double high) {
  // Ends and middle come up often: they are where regimes meet.
  const int step = *rc::gen::inRange(0, 1'000'001);
  return low + (high - low) * step / 1e6;
}

double sometimes_zero(double low, double high) {
  return *rc::gen::inRange(0, 8) == 0 ? 0.0 : between(low, high);
}

Case any_impact() {
  Case x;
  x.ball = {.diameter_m = between(0.02, 0.3), .mass_kg = 0.0576, .alpha = between(0.2, 2.0 / 3.0)};
  x.in.vx_mps = sometimes_zero(-40.0, 40.0);
  x.in.vy_mps = between(-40.0, -0.01);
  const int kind = *rc::gen::inRange(0, 6);
  const double radius = x.ball.radius_m();
  x.in.omega_radps = kind == 0 ? 0.0 : kind == 1 ? -x.in.vx_mps / radius : between(-60.0, 60.0) / radius;
  x.c = {.e = between(0.0, 1.0),
         .mu = sometimes_zero(0.0, 1.5),
         .e_x = sometimes_zero(-1.0, 1.0),
         .offset_m = sometimes_zero(0.0, 0.3) * radius,
         .offset_reference_mps = between(0.01, 10.0)};
  return x;
}

double tangential_energy(const Ball& b, const Motion& m) {
  return 0.5 * (m.vx_mps * m.vx_mps + b.alpha * std::pow(b.radius_m() * m.omega_radps, 2));
}

double speed_scale(const Case& x) {
  return std::abs(x.in.vx_mps) + std::abs(x.ball.radius_m() * x.in.omega_radps) + std::abs(x.in.vy_mps);
}

}  // namespace

TEST_GROUP(ReboundProperties){};

TEST(ReboundProperties, AMirroredImpactReboundsMirrored) {
  CHECK(rc::check("mirror", [] {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const auto m = *grip(x.ball, {-x.in.vx_mps, x.in.vy_mps, -x.in.omega_radps}, x.c);
    RC_ASSERT(m.lift_off.vx_mps == -r.lift_off.vx_mps);
    RC_ASSERT(m.lift_off.omega_radps == -r.lift_off.omega_radps);
    RC_ASSERT(m.lift_off.vy_mps == r.lift_off.vy_mps);
    RC_ASSERT(m.regime == r.regime);
  }));
}

// Rounding: some ten operations on squares of the speeds.
TEST(ReboundProperties, NoImpactAddsEnergy) {
  CHECK(rc::check("energy", [] {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const double slack = 1e-14 * std::pow(speed_scale(x), 2);
    RC_ASSERT(tangential_energy(x.ball, r.lift_off) <= tangential_energy(x.ball, x.in) + slack);
    RC_ASSERT(std::abs(r.lift_off.vy_mps) <= std::abs(x.in.vy_mps));
  }));
}

TEST(ReboundProperties, FrictionStaysWithinItsLimitAndTheTorquesBalance) {
  CHECK(rc::check("friction", [] {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const double impulse = (1.0 + x.c.e) * std::abs(x.in.vy_mps);
    const double dvx = r.lift_off.vx_mps - x.in.vx_mps, slack = 1e-13 * speed_scale(x);
    RC_ASSERT(std::abs(dvx) <= x.c.mu * impulse + slack);
    const double radius = x.ball.radius_m();
    const double turning = x.ball.alpha * radius * (r.lift_off.omega_radps - x.in.omega_radps);
    RC_ASSERT(std::abs(turning - (dvx + r.offset_m * impulse / radius)) <= slack);
    RC_ASSERT(std::abs(r.offset_m) <= x.c.offset_m);
    RC_ASSERT(r.offset_m * (x.in.vx_mps - radius * x.in.omega_radps) >= 0.0);
  }));
}

// The outputs follow the inputs without jumps; where the offset is lessened for energy's sake they may do so
// as a square root does: sqrt(1e-10) of the speeds, with room for the slopes.
TEST(ReboundProperties, ReboundsAreContinuousInTheTouchdown) {
  CHECK(rc::check("continuity", [] {
    const Case x = any_impact();
    const double scale = speed_scale(x), radius = x.ball.radius_m();
    Motion near = x.in;
    near.vx_mps += 1e-10 * scale * *rc::gen::inRange(-1, 2);
    near.vy_mps *= 1.0 + 1e-10 * *rc::gen::inRange(-1, 2);
    near.omega_radps += 1e-10 * scale / radius * *rc::gen::inRange(-1, 2);
    const auto a = *grip(x.ball, x.in, x.c);
    const auto b = *grip(x.ball, near, x.c);
    const double limit = 1e-3 * scale;
    RC_ASSERT(std::abs(a.lift_off.vx_mps - b.lift_off.vx_mps) <= limit);
    RC_ASSERT(radius * std::abs(a.lift_off.omega_radps - b.lift_off.omega_radps) <= limit);
  }));
}

TEST(ReboundProperties, WithoutAnOffsetAGripTurnsTheSlipIntoItsRestitutionAndASlideNeverReversesIt) {
  CHECK(rc::check("slip", [] {
    Case x = any_impact();
    x.c.offset_m = 0.0;
    const auto r = *grip(x.ball, x.in, x.c);
    const double slip = x.in.vx_mps + x.ball.radius_m() * x.in.omega_radps;
    const double slack = 1e-13 * speed_scale(x);
    if (r.regime == Regime::grips) {
      RC_ASSERT(std::abs(r.slip_lo_mps + x.c.e_x * slip) <= slack);
    } else {
      RC_ASSERT((r.slip_lo_mps + x.c.e_x * slip) * slip >= -slack * std::abs(slip));
      RC_ASSERT(std::abs(r.slip_lo_mps) <= std::abs(slip) + slack);
    }
  }));
}
