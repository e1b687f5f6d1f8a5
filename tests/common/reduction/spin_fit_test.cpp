#include <cmath>
#include <random>

#include "common/reduction/spin_check.hpp"
#include "common/reduction/spin_fit.hpp"
#include "common/units/angles.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;

namespace {

std::vector<EquatorReading> readings(double omega, double phase, const std::vector<double>& times,
                                     double sd = 0.0175) {
  std::vector<EquatorReading> result;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double angle = phase + omega * times[i];
    EquatorReading r;
    r.time_s = times[i];
    r.angle_rad = angle - kPi * std::floor(angle / kPi);
    r.sd_rad = sd;
    r.index = i;
    result.push_back(r);
  }
  return result;
}

const std::vector<double> kFive{0.0, 0.003, 0.006, 0.009, 0.012};

}  // namespace

TEST_GROUP(SpinFitting){};

TEST(SpinFitting, IsExactAtEveryPhaseAndSpinWithinTheWindow) {
  for (double omega = -490.0; omega <= 490.0; omega += 35.0) {
    for (int phase = 0; phase < 50; ++phase) {
      const auto fit = fit_spin(readings(omega, kPi * phase / 50.0, kFive));
      CHECK_TRUE(fit.has_value());
      DOUBLES_EQUAL(omega, fit->omega_radps, 1e-9);
    }
  }
}

TEST(SpinFitting, VarianceIsThatOfAStraightLine) {
  // Five times 3 ms apart: sum of squares about the mean is 10 * (3 ms)^2.
  const auto fit = fit_spin(readings(100.0, 0.2, kFive, 0.01));
  DOUBLES_EQUAL(1e-4 / (10.0 * 9e-6), fit->variance, 1e-9);
}

TEST(SpinFitting, ErrorsInTimeWidenTheVarianceButAreNotEstimatedNoise) {
  // 0.1 ms at 100 rad/s are 0.01 rad, as much as the reading's own sd: twice the variance, half of it the
  // readings'.
  auto r = readings(100.0, 0.2, kFive, 0.01);
  for (EquatorReading& e : r) e.time_sd_s = 1e-4;
  const double variance = 2e-4 / (10.0 * 9e-6);
  DOUBLES_EQUAL(variance, fit_spin(r)->variance, 1e-9);
  DOUBLES_EQUAL(0.0, fit_spin(r)->estimated_variance, 0.0);
  for (EquatorReading& e : r) e.estimated_noise = true;
  DOUBLES_EQUAL(variance, fit_spin(r)->variance, 1e-9);
  DOUBLES_EQUAL(0.5 * variance, fit_spin(r)->estimated_variance, 1e-9);
}

TEST(SpinFitting, OneBadReadingDoesNotChooseTheBranch) {
  for (std::size_t bad = 0; bad < 5; ++bad) {
    auto r = readings(-350.0, 1.0, kFive);
    r[bad].angle_rad += 1.2;
    const auto fit = fit_spin(r);
    // Its pull: 1.2 rad times its share of the slope, at most 0.2 / 3 ms: 80 rad/s. Another branch is 1047
    // off.
    DOUBLES_EQUAL(-350.0, fit->omega_radps, 85.0);
  }
}

TEST(SpinFitting, AMissingReadingKeepsTheWindowOfTheShortestInterval) {
  const auto fit = fit_spin(readings(400.0, 0.3, {0.0, 0.006, 0.009, 0.015}));
  DOUBLES_EQUAL(400.0, fit->omega_radps, 1e-9);
}

TEST(SpinFitting, LeftOutReadingsStillTellHalfTurns) {
  const auto used = readings(-305.0, 0.3, {0.0, 0.009, 0.018, 0.027, 0.036}, 0.001);
  auto left_out = readings(-305.0, 0.3, {0.003, 0.006, 0.012, 0.015, 0.024}, 0.001);
  left_out[1].angle_rad += 0.7;  // one was no image of the ball
  // By themselves they cannot tell half a turn in 9 ms more.
  DOUBLES_EQUAL(-305.0 + kPi / 0.009, fit_spin(used)->omega_radps, 1e-6);
  const auto fit = fit_spin(used, left_out);
  DOUBLES_EQUAL(-305.0, fit->omega_radps, 1e-6);
  CHECK_FALSE(fit->aliased);
  DOUBLES_EQUAL(fit_spin(used)->variance, fit->variance, 1e-9);
}

TEST(SpinFitting, ALongLegDoesNotLoseAHalfTurnToNoise) {
  std::mt19937_64 random(9);
  std::vector<double> times;
  for (int i = 0; i < 60; ++i) times.push_back(i * 0.003);
  for (int shot = 0; shot < 200; ++shot) {
    auto r = readings(-450.0, 0.1 * shot, times, 0.1);
    for (EquatorReading& e : r) e.angle_rad += 0.1 * std::normal_distribution<double>()(random);
    const auto fit = fit_spin(r);
    // sd: 0.1 / sqrt(60^3 / 12) / 3 ms = 0.25 rad/s.
    DOUBLES_EQUAL(-450.0, fit->omega_radps, 5 * 0.25);
  }
}

TEST(SpinFitting, TwoReadingsGiveTheSmallestTurn) {
  const auto fit = fit_spin(readings(-120.0, 0.05, {0.0, 0.003}));
  DOUBLES_EQUAL(-120.0, fit->omega_radps, 1e-9);
  CHECK_FALSE(fit_spin(readings(0.0, 0.0, {0.0})).has_value());
}

TEST(SpinFitting, SaysWhenAnotherTurnFitsAlike) {
  CHECK_TRUE(fit_spin(readings(515.0, 0.0, kFive))->aliased);
  CHECK_TRUE(fit_spin(readings(-515.0, 0.0, kFive))->aliased);
  CHECK_FALSE(fit_spin(readings(300.0, 0.0, kFive))->aliased);
}

TEST_GROUP(SpinCheck) {
  Readout readout;
  ShotFit fit;

  /// Alpha times the radius is 25 mm, so that 400 rad/s more spin are 10 m/s of the rim; vy is -6 and then 4 m/s.
  void setup() override {
    fit.observations.ball = {.diameter_m = 0.1, .mass_kg = 0.0576, .alpha = 0.5};
    readout.value[Quantity::omega_td_radps] = -100.0;
    readout.value[Quantity::omega_lo_radps] = 300.0;
    readout.value[Quantity::vx_td_mps] = 30.0;
    readout.value[Quantity::vy_td_mps] = -6.0;
    readout.value[Quantity::vy_lo_mps] = 4.0;
  }
  /// Of the shortest intervals of both legs, where friction and travel contradict each other by that much.
  bool flagged(double incoming_s, double rebound_s, double contradiction_mps) {
    fit.equators[0] = readings(0.0, 0.0, {0.0, 2.0 * incoming_s, 3.0 * incoming_s});
    fit.equators[1] = readings(0.0, 0.0, {0.0, rebound_s, 3.0 * rebound_s});
    readout.value[Quantity::vx_lo_mps] = 30.0 - (contradiction_mps - 10.0);
    return spins_contradict_friction(readout, fit);
  }
  void threshold(double expected_mps, double incoming_s, double rebound_s) {
    for (const auto& [one, other] : {std::pair(incoming_s, rebound_s), std::pair(rebound_s, incoming_s)}) {
      CHECK_FALSE(flagged(one, other, expected_mps - 0.01) || flagged(one, other, 0.01 - expected_mps));
      CHECK_TRUE(flagged(one, other, expected_mps + 0.01) && flagged(one, other, -expected_mps - 0.01));
    }
  }
};

TEST(SpinCheck, AsksForHalfOfAHalfTurnWhereBothLegsAreAsWellKnown) {
  threshold(0.5 * 0.025 * kPi / 2e-3, 2e-3, 2e-3);
  threshold(0.5 * 0.025 * kPi / 2.9e-3, 2e-3, 2.9e-3);
  threshold(0.5 * 0.025 * kPi / 6.9e-3, 6.9e-3, 6.9e-3);
}

TEST(SpinCheck, AsksForAHalfTurnLessTheOffsetOfTheNormalForceWhereALegHasGaps) {
  // Half of the radius times the change of vy, 10 m/s.
  threshold(0.025 * kPi / 3.1e-3 - 5.0, 2e-3, 3.1e-3);
}

TEST(SpinCheck, SaysNothingWhereAnySpinIsPossibleOrANumberIsMissing) {
  CHECK_FALSE(flagged(7.1e-3, 7.1e-3, 100.0));
  for (const Quantity q : {Quantity::omega_td_radps, Quantity::omega_lo_radps, Quantity::vx_td_mps,
                           Quantity::vx_lo_mps, Quantity::vy_td_mps, Quantity::vy_lo_mps}) {
    CHECK_TRUE(flagged(2e-3, 2e-3, 100.0));
    const auto value = std::exchange(readout.value[q], std::nullopt);
    CHECK_FALSE(spins_contradict_friction(readout, fit));
    readout.value[q] = value;
  }
  fit.equators[1].resize(1);
  CHECK_FALSE(spins_contradict_friction(readout, fit));
}
