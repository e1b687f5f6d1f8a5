#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <rapidcheck.h>
#include <set>
#include <string>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/physics/thesis_folder.hpp"
#include "tests/support/property.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using ball::Ball;
using strobe::testing::between;
using strobe::testing::holds_of_all;
using strobe::testing::one_in;
using strobe::testing::sometimes;
using strobe::testing::thesis_data;
using strobe::testing::Worst;

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

double sometimes_zero(double low, double high) { return sometimes(0.0, between(low, high), 8); }

Case any_impact() {
  Case x;
  x.ball = {.diameter_m = between(0.02, 0.3), .mass_kg = 0.0576, .alpha = between(0.2, 2.0 / 3.0)};
  x.in.vx_mps = sometimes_zero(-40.0, 40.0);
  x.in.vy_mps = between(-40.0, -0.01);
  const double radius = x.ball.radius_m();
  x.in.omega_radps = sometimes(0.0, sometimes(-x.in.vx_mps / radius, between(-60.0, 60.0) / radius));
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
  CHECK(holds_of_all([] {
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
  CHECK(holds_of_all([](Worst& worst) {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const double slack = 1e-14 * std::pow(speed_scale(x), 2);
    RC_ASSERT(worst.within(tangential_energy(x.ball, r.lift_off) - tangential_energy(x.ball, x.in), slack));
    RC_ASSERT(std::abs(r.lift_off.vy_mps) <= std::abs(x.in.vy_mps));
  }));
}

TEST(ReboundProperties, FrictionStaysWithinItsLimitAndTheTorquesBalance) {
  CHECK(holds_of_all([](Worst& worst) {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const double impulse = (1.0 + x.c.e) * std::abs(x.in.vy_mps);
    const double dvx = r.lift_off.vx_mps - x.in.vx_mps, slack = 1e-13 * speed_scale(x);
    RC_ASSERT(worst.within(std::abs(dvx) - x.c.mu * impulse, slack));
    const double radius = x.ball.radius_m();
    const double turning = x.ball.alpha * radius * (r.lift_off.omega_radps - x.in.omega_radps);
    RC_ASSERT(worst.within(std::abs(turning - (dvx + r.offset_m * impulse / radius)), slack));
    RC_ASSERT(std::abs(r.offset_m) <= x.c.offset_m);
    RC_ASSERT(r.offset_m * (x.in.vx_mps - radius * x.in.omega_radps) >= 0.0);
  }));
}

// Of touchdown, ball and coefficients: the outputs follow the inputs without jumps; where the offset is lessened for energy's sake they may do so
// as a square root does: sqrt(1e-10) of the speeds, with room for the slopes.
TEST(ReboundProperties, ReboundsAreContinuousInEveryInput) {
  CHECK(holds_of_all([](Worst& worst) {
    const Case x = any_impact();
    const double scale = speed_scale(x), radius = x.ball.radius_m();
    Motion near = x.in;
    near.vx_mps += 1e-10 * scale * *rc::gen::inRange(-1, 2);
    near.vy_mps *= 1.0 + 1e-10 * *rc::gen::inRange(-1, 2);
    near.omega_radps += 1e-10 * scale / radius * *rc::gen::inRange(-1, 2);
    Case other = x;
    for (double* input : {&other.ball.alpha, &other.ball.diameter_m, &other.c.e, &other.c.mu, &other.c.e_x,
                          &other.c.offset_m, &other.c.offset_reference_mps})
      if (one_in(2)) *input *= 1.0 - 1e-10;
    const auto a = *grip(x.ball, x.in, x.c);
    const auto b = *grip(other.ball, near, other.c);
    const double limit = 1e-3 * scale;
    RC_ASSERT(worst.within(std::abs(a.lift_off.vx_mps - b.lift_off.vx_mps), limit));
    RC_ASSERT(worst.within(radius * std::abs(a.lift_off.omega_radps - b.lift_off.omega_radps), limit));
  }));
}

TEST(ReboundProperties, WithoutAnOffsetAGripTurnsTheSlipIntoItsRestitutionAndASlideNeverReversesIt) {
  CHECK(holds_of_all([](Worst& worst) {
    Case x = any_impact();
    x.c.offset_m = 0.0;
    const auto r = *grip(x.ball, x.in, x.c);
    const double slip = x.in.vx_mps + x.ball.radius_m() * x.in.omega_radps;
    const double slack = 1e-13 * speed_scale(x);
    if (r.regime == Regime::grips) {
      RC_ASSERT(worst.within(std::abs(r.slip_lo_mps + x.c.e_x * slip), slack));
    } else {
      RC_ASSERT((r.slip_lo_mps + x.c.e_x * slip) * slip >= -slack * std::abs(slip));
      RC_ASSERT(worst.within(std::abs(r.slip_lo_mps) - std::abs(slip), slack));
    }
  }));
}

// A unit that is a power of two times another changes exponents only.
TEST(ReboundProperties, OtherUnitsOfTimeAndLengthGiveTheSameReboundToTheLastBit) {
  CHECK(holds_of_all([] {
    const Case x = any_impact();
    const int time_power = *rc::gen::inRange(-30, 31), length_power = *rc::gen::inRange(-20, 21);
    const auto speed = [&](double v) { return std::ldexp(v, length_power - time_power); };
    Case other = x;
    other.ball.diameter_m = std::ldexp(x.ball.diameter_m, length_power);
    other.in = {speed(x.in.vx_mps), speed(x.in.vy_mps), std::ldexp(x.in.omega_radps, -time_power)};
    other.c.offset_m = std::ldexp(x.c.offset_m, length_power);
    other.c.offset_reference_mps = speed(x.c.offset_reference_mps);
    const auto a = *grip(x.ball, x.in, x.c), b = *grip(other.ball, other.in, other.c);
    RC_ASSERT(b.lift_off.vx_mps == speed(a.lift_off.vx_mps));
    RC_ASSERT(b.lift_off.vy_mps == speed(a.lift_off.vy_mps));
    RC_ASSERT(b.lift_off.omega_radps == std::ldexp(a.lift_off.omega_radps, -time_power));
    RC_ASSERT(b.impulse_ratio == a.impulse_ratio);
    RC_ASSERT(b.offset_m == std::ldexp(a.offset_m, length_power));
    RC_ASSERT(b.regime == a.regime);
  }));
}

// Friction's impulse is the lesser of what it can give, mu·J, and what gripping takes, which does not depend on mu: along
// a fine scan of mu it grows by no more than J each, and not at all any more once the ball grips. It grows with e as J
// does until it grips. The height of the rebound grows with e.
TEST(ReboundProperties, WithoutAnOffsetFrictionGrowsWithMuUntilTheBallGripsAndLiftOffSpeedWithE) {
  CHECK(holds_of_all([](Worst& worst) {
    Case x = any_impact();
    x.c.offset_m = 0.0;
    const double impulse = (1.0 + x.c.e) * std::abs(x.in.vy_mps), slack = 1e-14 * speed_scale(x);
    std::optional<Rebound> last;
    for (int i = 0; i <= 200; ++i) {
      x.c.mu = 0.01 * i;
      const Rebound r = *grip(x.ball, x.in, x.c);
      if (last) {
        const double step = std::abs(r.impulse_ratio) - std::abs(last->impulse_ratio);
        RC_ASSERT(worst.within(std::max(-step, step - 0.01) * impulse, slack));
        if (last->regime == Regime::grips) {
          RC_ASSERT(r.regime == Regime::grips && r.lift_off.vx_mps == last->lift_off.vx_mps);
        }
      }
      last = r;
    }
    for (int i = 0; i < 200; ++i) {
      x.c.e = 0.005 * i;
      const Rebound a = *grip(x.ball, x.in, x.c);
      x.c.e += 0.005;
      const Rebound b = *grip(x.ball, x.in, x.c);
      RC_ASSERT(b.lift_off.vy_mps > a.lift_off.vy_mps);
      const double less = std::abs(a.lift_off.vx_mps - x.in.vx_mps) - std::abs(b.lift_off.vx_mps - x.in.vx_mps);
      RC_ASSERT(worst.within(less, slack));
    }
  }));
}
