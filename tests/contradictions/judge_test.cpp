// The judge finds a planted wrong number, and lets pass what a flag explains.
#include <cmath>

#include "tests/contradictions/report.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::contradictions;
using reduction::Flag;
using reduction::Quantity;
using reduction::Readout;

namespace {

Scene gripping() {
  Scene scene;
  scene.impact = {.vx_mps = 10.0, .vy_mps = -10.0, .omega_radps = 100.0, .mu = 0.8};
  return scene;
}

/// Every number right, with an sd of 1 % of it.
Readout perfect(const Truth& truth) {
  Readout readout;
  readout.value = truth.value;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    readout.sd[q] = 0.01 * std::abs(*truth.value[q]);
  }
  return readout;
}

}  // namespace

TEST_GROUP(Judge) {
  const Truth is = truth(gripping());
  Readout readout = perfect(is);

  void plant(Quantity q, double sds) { *readout.value[q] += sds * *readout.sd[q]; }
};

TEST(Judge, FindsNothingInATrueReadout) {
  const Judgement j = judged(readout, is, Kind::none);
  CHECK(j.silent.none() && j.flagged.none() && j.few.none());
}

TEST(Judge, FindsAPlantedWrongNumber) {
  plant(Quantity::vx_td_mps, 7.0);
  const Judgement j = judged(readout, is, Kind::outlier_centre);
  CHECK(j.silent.test(static_cast<std::size_t>(Quantity::vx_td_mps)));
  CHECK_EQUAL(1U, j.silent.count());
  DOUBLES_EQUAL(7.0, j.worst, 1e-9);
}

TEST(Judge, LetsPassWhatIsWithinSixSd) {
  plant(Quantity::vx_td_mps, 5.9);
  CHECK(judged(readout, is, Kind::outlier_centre).silent.none());
}

TEST(Judge, TakesTheTolerancesWithTheNoise) {
  plant(Quantity::vx_td_mps, 7.0);
  readout.sd_systematic[Quantity::vx_td_mps] = *readout.sd[Quantity::vx_td_mps];  // 7 / sqrt(2) = 4.9
  CHECK(judged(readout, is, Kind::outlier_centre).silent.none());
}

TEST(Judge, LetsPassWhatNoExperimentNotices) {
  readout.sd[Quantity::vx_td_mps] = 1e-5;
  plant(Quantity::vx_td_mps, 1000.0);  // 0.01 m/s
  CHECK(judged(readout, is, Kind::outlier_centre).silent.none());
}

TEST(Judge, LetsPassWhatAFlagExplains) {
  plant(Quantity::vx_td_mps, 7.0);
  readout.flags.set(Flag::outlier_image);
  const Judgement j = judged(readout, is, Kind::outlier_centre);
  CHECK(j.silent.none());
  CHECK(j.flagged.any());
}

TEST(Judge, LetsNoFlagExcuseAnotherTrouble) {
  plant(Quantity::vx_td_mps, 7.0);
  readout.flags.set(Flag::outlier_image);
  CHECK(judged(readout, is, Kind::scale).silent.any());
  CHECK(judged(readout, is, Kind::none).silent.any());
}

TEST(Judge, LetsAnAliasedSpinExcuseSpinsOnly) {
  readout.flags.set(Flag::spin_aliased);
  plant(Quantity::omega_td_radps, 50.0);
  CHECK(judged(readout, is, Kind::long_period).silent.none());
  plant(Quantity::theta_in_deg, 50.0);
  const Judgement j = judged(readout, is, Kind::long_period);
  CHECK(j.silent.test(static_cast<std::size_t>(Quantity::theta_in_deg)));
  CHECK_EQUAL(1U, j.silent.count());
}

TEST(Judge, CountsApartWhatOnlySaysThatImagesAreFew) {
  plant(Quantity::vx_td_mps, 7.0);
  readout.flags.set(Flag::no_redundancy);
  const Judgement j = judged(readout, is, Kind::outlier_centre, true);
  CHECK(j.silent.none() && j.flagged.none() && j.few.any());
  // Few of what is right excuse nothing.
  CHECK(judged(readout, is, Kind::outlier_centre, false).silent.any());
}

TEST(Judge, WidensItsLimitWhereTheNoiseWasEstimated) {
  plant(Quantity::vx_td_mps, 7.0);
  readout.degrees_of_freedom[Quantity::vx_td_mps] = 2.0;  // 95 % within 4.30 / 1.32 sd = 3.3 instead of 2
  CHECK(judged(readout, is, Kind::outlier_centre).silent.none());
  plant(Quantity::vx_td_mps, 5.0);
  CHECK(judged(readout, is, Kind::outlier_centre).silent.any());
}

TEST(Judge, FindsAWrongVerdict) {
  readout.regime = Regime::slides;  // of a ball that rolls off
  CHECK_TRUE(judged(readout, is, Kind::alpha).slides_wrongly);
  readout.regime = Regime::grips;
  CHECK_FALSE(judged(readout, is, Kind::alpha).slides_wrongly);
  Scene sliding = gripping();
  sliding.impact.mu = 0.05;
  const Truth slid = truth(sliding);
  Readout other = perfect(slid);
  other.regime = Regime::grips;
  CHECK_TRUE(judged(other, slid, Kind::alpha).grips_wrongly);
  other.regime = Regime::unclear;
  CHECK_FALSE(judged(other, slid, Kind::alpha).grips_wrongly);
}

TEST_GROUP(Tally){};

TEST(Tally, MergesWhatWasCountedApart) {
  // A wrong ball without a calibrated scale is wrong in most shots, and beyond proof.
  Tally first, second, all;
  for (std::uint64_t number = 1; number <= 100; ++number) {
    const Shot shot = drawn_shot(Kind::ball_size_uncalibrated, {}, 1, number);
    (number <= 50 ? first : second).add(shot, number);
    all.add(shot, number);
  }
  first.merge(second);
  CHECK_EQUAL(100, first.shots);
  CHECK(all.unprovable > 0 && all.silent == 0);
  CHECK_EQUAL(all.unprovable, first.unprovable);
  CHECK_EQUAL(all.coverage[0].within_68, first.coverage[0].within_68);
  CHECK_EQUAL(all.worst_unprovable.front().number, first.worst_unprovable.front().number);
}

TEST(Tally, LimitsAShareByWhatWasSeen) {
  // Wilson: of none in n at most z^2 / (n + z^2), z = 1.645.
  const double z2 = 1.6448536269514722 * 1.6448536269514722;
  DOUBLES_EQUAL(z2 / (1000.0 + z2), upper_limit_95(0, 1000), 1e-12);
  CHECK(upper_limit_95(10, 1000) > 0.01);
  DOUBLES_EQUAL(1.0, upper_limit_95(0, 0), 0.0);
}
