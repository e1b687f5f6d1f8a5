#include <algorithm>
#include <cmath>
#include <random>

#include "common/reduction/equator_consensus.hpp"
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
  CHECK_FALSE(fit->near_limit);
  CHECK_TRUE(fit->alternatives_radps.empty());
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
  CHECK_TRUE(fit_spin(readings(515.0, 0.0, kFive))->near_limit);
  CHECK_TRUE(fit_spin(readings(-515.0, 0.0, kFive))->near_limit);
  CHECK_FALSE(fit_spin(readings(300.0, 0.0, kFive))->near_limit);
}

TEST(SpinFitting, FlashesWithoutAReadingStillBoundTheTurnPerFlash) {
  // Half a turn in 9 ms is 349 rad/s: three spins within the window of 3 ms, one within that of 9 ms.
  const auto r = readings(259.0, 0.4, {0.0, 0.009});
  const auto alone = fit_spin(r);
  DOUBLES_EQUAL(259.0 - kPi / 0.009, alone->omega_radps, 1e-9);
  CHECK_TRUE(alone->alternatives_radps.empty());
  const auto fit = fit_spin(r, {}, {.shortest_interval_s = 0.003, .fastest_radps = 600.0});
  DOUBLES_EQUAL(kPi / 0.006, fit->window_radps, 1e-9);
  DOUBLES_EQUAL(259.0 - kPi / 0.009, fit->omega_radps, 1e-9);  // the slowest of spins that are as likely
  std::vector<double> others = fit->alternatives_radps;
  std::ranges::sort(others);
  LONGS_EQUAL(2, others.size());
  DOUBLES_EQUAL(259.0 - 2.0 * kPi / 0.009, others[0], 1e-9);
  DOUBLES_EQUAL(259.0, others[1], 1e-9);
}

TEST(SpinFitting, SpinsBeyondTheWindowAreNamedUpToTheFastest) {
  // A turn more in each 5 ms is 628 rad/s.
  const auto r = readings(-100.0, 0.4, {0.0, 0.005, 0.010, 0.015});
  CHECK_TRUE(fit_spin(r, {}, {0.005, 500.0})->alternatives_radps.empty());
  const auto fit = fit_spin(r, {}, {0.005, 600.0});
  LONGS_EQUAL(1, fit->alternatives_radps.size());
  DOUBLES_EQUAL(-100.0 + kPi / 0.005, fit->alternatives_radps[0], 1e-9);
  LONGS_EQUAL(2, fit_spin(r, {}, {0.005, 800.0})->alternatives_radps.size());
}

TEST(SpinFitting, UnequalIntervalsTellASpinBeyondTheWindow) {
  const std::vector<double> coded{0.0, 0.005, 0.0112, 0.0165, 0.0223};
  const auto fit = fit_spin(readings(500.0, 0.4, coded), {}, {0.005, 630.0});
  DOUBLES_EQUAL(500.0, fit->omega_radps, 1e-9);
  CHECK_FALSE(fit->near_limit);
}

TEST(SpinFitting, ReadingsThatNoSpinExplainsStayWithinTheWindow) {
  // Through a lens that was not undone equators are off by far more than their noise. Where intervals differ a little,
  // spins beyond the window miss them by other amounts: now and then by less, and by far too much.
  std::mt19937_64 random(20261122);
  std::uniform_real_distribution<double> error(-0.06, 0.06);
  int beyond = 0;
  for (int draw = 0; draw < 1000; ++draw) {
    auto r = readings(-300.0, 0.4, {0.0, 0.003, 0.00605, 0.00915});
    for (EquatorReading& reading : r) reading.angle_rad += error(random), reading.sd_rad = 0.002;
    const auto fit = fit_spin(r, {}, {.shortest_interval_s = 0.003, .fastest_radps = 1500.0});
    beyond += std::abs(fit->omega_radps) > fit->window_radps ? 1 : 0;
  }
  // By chance two residuals within .12 rad are within some five sd of the two of a spin beyond it: a share of
  // (pi/4)(2 · 5 · .002 / .12)^2 for each of three such spins.
  CHECK_COMPARE(beyond, <=, 30);
}

TEST(SpinFitting, TheDecayInFlightIsPartOfTheLine) {
  // 20 images at 17 m/s; over 57 ms of 0.17 per second the angle bends by 0.02 rad, twenty sd.
  std::vector<EquatorReading> r;
  const double decay = 0.17, omega = 300.0, mean_s = 0.0285;
  for (int i = 0; i < 20; ++i) {
    const double t = 0.003 * i;
    const double angle = -omega / decay * std::expm1(-decay * (t - mean_s));
    r.push_back({.time_s = t, .angle_rad = wrap_half_turn(angle), .sd_rad = 0.001});
  }
  const auto fit = fit_spin(r, {}, {.decay_per_s = decay});
  DOUBLES_EQUAL(mean_s, fit->time_s, 1e-12);
  DOUBLES_EQUAL(omega, fit->omega_radps, 1e-7);
  CHECK_TRUE(fit->chi_squared < 1e-9);
  CHECK_TRUE(fit_spin(r)->chi_squared > 100.0);
}

namespace {

/// Without noise, read to 1 mrad, decaying otherwise than by the 0.17 per second that a fit assumes.
std::vector<EquatorReading> decaying(double omega, double decay, int count, double period_s = 0.003) {
  std::vector<EquatorReading> result;
  for (int i = 0; i < count; ++i) {
    const double t = period_s * i;
    const double angle = -omega / decay * std::expm1(-decay * t);
    result.push_back({.time_s = t, .angle_rad = wrap_half_turn(angle), .sd_rad = 0.001});
  }
  return result;
}

constexpr SpinSearch kDecayKnownToHalf{0.003, 1200.0, 0.17, 0.085};

}  // namespace

TEST(SpinFitting, WhatIsNotKnownOfTheDecayIsNoResidual) {
  for (const double sds : {-1.5, 1.0, 2.0}) {
    const auto r = decaying(350.0, 0.17 + sds * 0.085, 20);
    const auto fit = fit_spin(r, {}, kDecayKnownToHalf);
    // Where the angles tell the decay well they say how far it is off, and nothing is left.
    DOUBLES_EQUAL(sds * sds, fit->decay_square, 0.03 * sds * sds);
    DOUBLES_EQUAL(fit->decay_square, fit->chi_squared, 0.05 * sds * sds);
    for (const double residual : fit->residual_rad) CHECK_TRUE(std::abs(residual) < 2e-4);
    LONGS_EQUAL(0, fit->alternatives_radps.size());
    SpinSearch exact = kDecayKnownToHalf;
    exact.decay_sd_per_s = 0.0;
    CHECK_TRUE(fit_spin(r, {}, exact)->chi_squared > 100.0);
  }
}

TEST(SpinFitting, TheDecayTakesOneMoreShareOfTheReadings) {
  // A line takes two of them; a parabola whose coefficient the readings tell far better than it was known one more.
  const auto fit = fit_spin(decaying(350.0, 0.17, 20), {}, kDecayKnownToHalf);
  double taken = 0.0;
  for (const double share : fit->leverage) taken += share;
  DOUBLES_EQUAL(3.0, taken, 0.02);
}

TEST(SpinFitting, AnotherDecayMakesNoOtherSpinLikelier) {
  // Half a turn more every 6 ms makes 774 of 250 rad/s. At the rate assumed, 0.17 per second, 774 slows by 132 rad/s in a
  // second and 250 by 42: the true 105 is nearer to the first.
  for (const double omega : {-250.0, 250.0}) {
    const auto r = decaying(omega, 0.42, 20, 0.006);
    SpinSearch search = kDecayKnownToHalf;
    search.shortest_interval_s = 0.006;
    const auto fit = fit_spin(r, {}, search);
    // At the mean time, 57 ms after the first image; the line's slope is that to the bend's third order.
    DOUBLES_EQUAL(omega * std::exp(-0.42 * 0.057), fit->omega_radps, 0.001 * std::abs(omega));
    LONGS_EQUAL(1, fit->alternatives_radps.size());
  }
}

TEST(SpinFitting, ALineThroughSomeOfTheReadingsIsNoOtherSpin) {
  // The angles bend by up to eighty sd off a line: one that follows an end of them leaves out the other.
  for (int sds = -1; sds <= 3; ++sds) {
    const auto fit = fit_spin(decaying(400.0, 0.17 + 0.085 * sds, 40), {}, kDecayKnownToHalf);
    for (const double other : fit->alternatives_radps) CHECK_TRUE(std::abs(other - fit->omega_radps) > 20.0);
  }
}

TEST(SpinFitting, AnotherSpinNeedNotDecayAtTheRateAssumed) {
  // Of -100 rad/s the decay bends the angle so far that 528, which bends it more and the other way, would be excluded.
  std::vector<double> times;
  for (int i = 0; i < 20; ++i) times.push_back(0.005 * i);
  const auto fit = fit_spin(readings(-100.0, 0.4, times, 0.005), {}, {0.005, 600.0, 0.2});
  LONGS_EQUAL(1, fit->alternatives_radps.size());
}

TEST_GROUP(SpinCheck) {
  Readout readout;
  ShotFit fit;

  /// Alpha is 0.5 and the radius 50 mm: the rim does 5 m/s at 100 rad/s. J is 10 m/s, of which an offset of the normal
  /// force takes up to 1.5 m/s; a tenth is left out of account.
  void setup() override {
    fit.observations.ball = {.diameter_m = 0.1, .mass_kg = 0.0576, .alpha = 0.5};
    readout.value[Quantity::vy_td_mps] = -6.0;
    readout.value[Quantity::vy_lo_mps] = 4.0;
    velocities(20.0, 15.0);
    spins(0.0, -200.0);
  }
  void velocities(double td_mps, double lo_mps) {
    readout.value[Quantity::vx_td_mps] = td_mps;
    readout.value[Quantity::vx_lo_mps] = lo_mps;
  }
  void spins(double td_radps, double lo_radps) {
    readout.value[Quantity::omega_td_radps] = td_radps;
    readout.value[Quantity::omega_lo_radps] = lo_radps;
    for (std::size_t leg = 0; leg < 2; ++leg) {
      fit.spin[leg].emplace().omega_radps = leg == 0 ? td_radps : lo_radps;
      fit.spin[leg]->window_radps = 300.0;
    }
  }
  bool allowed(double td_radps, double lo_radps) const {
    return Friction::of(readout, fit)->allows(td_radps, lo_radps);
  }
};

TEST(SpinCheck, FrictionTurnsTheBallByWhatItTakesFromItsTravel) {
  // 5 m/s of travel turn the rim by 7.5 m/s (alpha 2/3) to 10 (1/2); the offset and a tenth make 5.1 (3.4 / (2/3)) and
  // 13.2 m/s (6.6 / 0.5) of it.
  CHECK_TRUE(allowed(0.0, -103.0));
  CHECK_FALSE(allowed(0.0, -101.0));
  CHECK_TRUE(allowed(0.0, -263.0));
  CHECK_FALSE(allowed(0.0, -265.0));
}

TEST(SpinCheck, TheNumbersOwnSdsAreAllowedFor) {
  // Four sd of 0.3 m/s each on both sides: 1.7 m/s more over 2/3.
  readout.sd[Quantity::vx_td_mps] = readout.sd[Quantity::vx_lo_mps] = 0.3;
  CHECK_TRUE(allowed(0.0, -53.0));
  CHECK_FALSE(allowed(0.0, -50.0));
}

TEST(SpinCheck, FrictionOpposesTheSlip) {
  // The rim at -30 m/s slips backwards: friction would drive the ball.
  CHECK_TRUE(allowed(0.0, -200.0));
  CHECK_FALSE(allowed(-600.0, -800.0));
  velocities(20.0, 25.0);
  CHECK_TRUE(allowed(-600.0, -400.0));
  // One that slid throughout, forwards, does not gain by an offset either.
  velocities(20.0, 20.9);
  CHECK_FALSE(allowed(0.0, 40.0));
}

TEST(SpinCheck, TheSlipDoesNotGrow) {
  // 10 m/s before; as much the other way after and, by the offset, 3 and a tenth.
  velocities(20.0, 12.0);
  CHECK_TRUE(allowed(-200.0, -501.0));
  CHECK_FALSE(allowed(-200.0, -503.0));
}

TEST(SpinCheck, NoSpinTakesEnergyFromNowhere) {
  // 20 m/s and 6: 20.9 before. After, 15 and 4 leave 13.9 m/s to the root of 1/2 of the rim's square: 393 rad/s.
  velocities(20.0, 15.0);
  CHECK_TRUE(Friction::of(readout, fit)->contradiction_mps(0.0, 396.0) < 100.0);
  CHECK_TRUE(Friction::of(readout, fit)->contradiction_mps(0.0, 400.0) > 100.0);
}

TEST(SpinCheck, SpinsThatNoOtherExplainsBetterAreNotInDoubt) {
  spins(0.0, 300.0);  // friction cannot have done it, nor anything else
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
  fit.spin[1]->alternatives_radps = {600.0};
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
  fit.spin[1]->alternatives_radps = {250.0};
  CHECK_TRUE(check_spins(readout, fit).in_doubt);
}

TEST(SpinCheck, BothSpinsAliasedAlikeAreInDoubt) {
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
  fit.spin[0]->alternatives_radps = {400.0};
  CHECK_FALSE(check_spins(readout, fit).in_doubt);  // with -200 friction excludes it
  fit.spin[1]->alternatives_radps = {200.0};
  CHECK_TRUE(check_spins(readout, fit).in_doubt);
}

TEST(SpinCheck, BeyondTheWindowNoSurfaceIsSmootherThanACourt) {
  // Slid with an impulse ratio of 0.1, or gripped.
  velocities(20.0, 19.0);
  spins(-380.0, -400.0);
  fit.spin[0]->alternatives_radps = {20.0};
  fit.spin[1]->alternatives_radps = {0.0};
  fit.spin[0]->window_radps = fit.spin[1]->window_radps = 10.0;
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
  fit.spin[0]->window_radps = fit.spin[1]->window_radps = 500.0;
  CHECK_TRUE(check_spins(readout, fit).in_doubt);
}

TEST(SpinCheck, OneSpinAloneIsHeldAgainstTheVelocities) {
  fit.spin[0].reset();
  readout.value[Quantity::omega_td_radps].reset();
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
  fit.spin[1]->alternatives_radps = {200.0};  // 400 rad/s before
  CHECK_TRUE(check_spins(readout, fit).in_doubt);
  fit.spin[1]->alternatives_radps = {500.0};  // 652 or more: the rim of no ball in flight
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
  readout.value[Quantity::vx_td_mps].reset();
  fit.spin[1]->alternatives_radps = {200.0};
  CHECK_TRUE(check_spins(readout, fit).in_doubt);
  fit.spin[1].reset();
  CHECK_FALSE(check_spins(readout, fit).in_doubt);
}

namespace {

constexpr double kSd_rad = 0.0175, kWindow_radps = 523.0, kFalse = 1e-3;

/// Every 3 ms, with noise.
std::vector<EquatorReading> spinning(double omega, int count, std::mt19937_64& random,
                                     bool estimated = false) {
  std::normal_distribution<double> noise(0.0, kSd_rad);
  std::vector<EquatorReading> all;
  for (int i = 0; i < count; ++i) {
    const double t = 0.003 * i;
    all.push_back({.time_s = t,
                   .angle_rad = wrap_half_turn(0.4 + omega * t + noise(random)),
                   .sd_rad = kSd_rad,
                   .estimated_noise = estimated});
  }
  return all;
}

}  // namespace

TEST_GROUP(EquatorConsensus) {
  std::mt19937_64 random{5};
  std::vector<std::size_t> outside(const std::vector<EquatorReading>& readings) const {
    return outside_consensus(readings, kWindow_radps, kSd_rad, kFalse);
  }
};

TEST(EquatorConsensus, FindsTheReadingsThatShareNoSpinWithTheRest) {
  for (const bool estimated : {false, true}) {
    auto readings = spinning(258.5, 9, random, estimated);
    readings[2].angle_rad += 0.8;
    readings[5].angle_rad += 0.8;
    readings[6].angle_rad -= 0.5;
    const auto found = outside(readings);
    LONGS_EQUAL(3, found.size());
    LONGS_EQUAL(2, found[0]);
    LONGS_EQUAL(5, found[1]);
    LONGS_EQUAL(6, found[2]);
  }
}

TEST(EquatorConsensus, LeavesCleanReadingsWhateverTheirNoise) {
  // Stated to a third of what it is: the consensus's own scatter tells.
  int lost = 0;
  for (int shot = 0; shot < 500; ++shot) {
    auto readings = spinning(-300.0, 8, random);
    if (shot % 2 == 0) {
      for (EquatorReading& r : readings) r.sd_rad /= 3.0;
    }
    lost += outside(readings).empty() ? 0 : 1;
  }
  CHECK_TRUE(lost <= 5);
}

TEST(EquatorConsensus, NeedsAMajorityOfThreeAndNoOtherAsGood) {
  auto readings = spinning(100.0, 4, random);
  readings[0].angle_rad += 0.8;
  readings[2].angle_rad += 0.4;
  CHECK_TRUE(outside(readings).empty());
  // Four and four.
  readings = spinning(100.0, 8, random);
  for (const std::size_t i : {1U, 3U, 5U, 7U}) readings[i].angle_rad += 0.7;
  CHECK_TRUE(outside(readings).empty());
}

TEST(EquatorConsensus, AgreeingReadingsNeedNoSearch) {
  auto readings = spinning(100.0, 8, random);
  CHECK_TRUE(equators_agree(readings, *fit_spin(readings), kSd_rad));
  readings[3].angle_rad += 0.5;
  CHECK_FALSE(equators_agree(readings, *fit_spin(readings), kSd_rad));
  for (EquatorReading& r : readings) r.estimated_noise = true, r.sd_rad = 0.1;
  CHECK_FALSE(equators_agree(readings, *fit_spin(readings), kSd_rad));
}
