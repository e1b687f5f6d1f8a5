#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/physics/thesis_folder.hpp"

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

struct Rms {
  double vx_mps = 0.0;
  double omega_radps = 0.0;
};

/// Root mean square of a model's lift-off less the measured one over the 21 conditions, with each one's e.
Rms rms_over_conditions(const std::function<Motion(const Motion&, double e)>& model) {
  Rms sum;
  const auto& conditions = thesis_data(thesis::Version::as_printed).conditions;
  for (const auto& c : conditions) {
    const Motion out = model(touchdown_of(c), c.e.mean);
    sum.vx_mps += std::pow(out.vx_mps - c.vx_lo_mps.mean, 2);
    sum.omega_radps += std::pow(out.omega_radps - c.omega_lo_radps.mean, 2);
  }
  const auto n = static_cast<double>(conditions.size());
  return {std::sqrt(sum.vx_mps / n), std::sqrt(sum.omega_radps / n)};
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
  CHECK(r->regime == Regime::slides);
  DOUBLES_EQUAL(15.0 - 0.3 * 9.0, r->lift_off.vx_mps, 1e-14);
  DOUBLES_EQUAL(4.0, r->lift_off.vy_mps, 0.0);
  DOUBLES_EQUAL(-0.3 * 9.0 / (2.0 / 3.0 * kRadius), r->lift_off.omega_radps, 1e-12);
  DOUBLES_EQUAL(0.3, r->impulse_ratio, 1e-15);
}

TEST(Rebound, RollingOffFollowsTheThesissEquations14And15) {
  const double omega = 40.0;
  const auto r = rigid(kThinShell, {10.0, -12.0, omega}, 0.7, 0.6);
  CHECK(r->regime == Regime::grips);
  const double vx = (3.0 * 10.0 - 2.0 * kRadius * omega) / 5.0;
  DOUBLES_EQUAL(vx, r->lift_off.vx_mps, 1e-14);
  DOUBLES_EQUAL(-vx / kRadius, r->lift_off.omega_radps, 1e-11);
  DOUBLES_EQUAL(0.0, r->slip_lo_mps, 1e-14);
}

TEST(Rebound, TopspinFasterThanRollingIsDrivenForward) {
  const auto r = rigid(kThinShell, {5.0, -8.0, -400.0}, 0.75, 0.1);
  CHECK(r->regime == Regime::slides);
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
  CHECK(predicted == (std::set<std::string>{"zero_17", "back_17", "back_22"}));
  CHECK(predicted == measured);
}

// Published coefficients have two or three digits; moving them by half of the last one moves the two rms
// within .4865….4994 m/s and 15.28…15.70 rad/s about our .491 and 15.47.
TEST(Rebound, AConstantOffsetGivesTheFitOverTables5To7) {
  // In all 21 conditions the ball rolls along +x, so a vanishing reference speed makes the offset constant.
  const Rms rms = rms_over_conditions([](const Motion& td, double e) {
    return grip(kMeasured, td,
                {.e = e, .mu = 0.567, .e_x = 0.089, .offset_m = 0.0025, .offset_reference_mps = 1e-9})
        ->lift_off;
  });
  DOUBLES_EQUAL(0.495, rms.vx_mps, 0.0085);
  DOUBLES_EQUAL(15.4, rms.omega_radps, 0.3);
}

// Published beside the fit: within one replicate sd in 8 (vx) and 11 (omega) of the 21 sets. Following the
// rolling it is within more of them.
TEST(Rebound, AConstantOffsetStaysWithinOneSdInFewerSetsThanOneThatFollowsRolling) {
  const auto within_one_sd = [](const Coefficients& coefficients) {
    std::pair<int, int> count{0, 0};
    for (const auto& c : thesis_data(thesis::Version::as_printed).conditions) {
      Coefficients with_e = coefficients;
      with_e.e = c.e.mean;
      const Motion out = grip(kMeasured, touchdown_of(c), with_e)->lift_off;
      count.first += std::abs(out.vx_mps - c.vx_lo_mps.mean) <= c.vx_lo_mps.sd ? 1 : 0;
      count.second += std::abs(out.omega_radps - c.omega_lo_radps.mean) <= c.omega_lo_radps.sd ? 1 : 0;
    }
    return count;
  };
  const auto constant =
      within_one_sd({.e = 0, .mu = 0.567, .e_x = 0.089, .offset_m = 0.0025, .offset_reference_mps = 1e-9});
  LONGS_EQUAL(8, constant.first);
  LONGS_EQUAL(11, constant.second);
  const auto rolling = within_one_sd(kFittedToThesis);
  CHECK(rolling.first > constant.first && rolling.second > constant.second);
}

TEST(Rebound, SlideAndRollGivesTheFitOverTables5To7) {
  const Rms rms = rms_over_conditions(
      [](const Motion& td, double e) { return rigid(kThinShell, td, e, 0.55)->lift_off; });
  DOUBLES_EQUAL(0.88, rms.vx_mps, 0.01);
  DOUBLES_EQUAL(30.0, rms.omega_radps, 0.5);
}

// Refitted with the offset odd in the rolling speed: better than the constant offset in both.
TEST(Rebound, TheOffsetThatFollowsRollingFitsBetterThanAConstantOne) {
  const Rms rms = rms_over_conditions([](const Motion& td, double e) {
    Coefficients c = kFittedToThesis;
    c.e = e;
    return grip(kMeasured, td, c)->lift_off;
  });
  CHECK(rms.vx_mps < 0.425);
  CHECK(rms.omega_radps < 14.4);
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
