// One rule for all numbers: passed, failed, not told apart, and how often each is wrong.
#include "host/commission/guard_band.hpp"

#include <cmath>
#include <random>

#include "host/commission/statistics.hpp"
#include "tests/host/commission/judged.hpp"

namespace {

using namespace strobe::commission;
using strobe::commission_test::is_not_told;

StepResult held(const Interval& found, const Limits& limits) {
  StepResult result = passed(1.0, {}, "", "");
  hold(result, found, limits, "off", "mend it");
  return result;
}

StepState state_of(double value, double sd, const Limits& limits) {
  return held(interval(value, sd), limits).state;
}

}  // namespace

TEST_GROUP(GuardBand){};

TEST(GuardBand, PassesFailsOrDoesNotTell) {
  const Limits limits = within(3.0, 12.0);
  CHECK(state_of(13.0, 0.9, limits) == StepState::passed);
  CHECK(state_of(13.0, 1.0, limits) == StepState::passed);  // its end is the limit
  CHECK(state_of(13.0, 1.1, limits) == StepState::not_told);
  CHECK(state_of(16.9, 1.0, limits) == StepState::not_told);
  CHECK(state_of(17.1, 1.0, limits) == StepState::failed);
  CHECK(state_of(7.1, 1.0, limits) == StepState::not_told);
  CHECK(state_of(6.9, 1.0, limits) == StepState::failed);
  CHECK(state_of(5.7, 5.6, limits) == StepState::not_told);
  CHECK(state_of(12.0, 5.6, limits) == StepState::not_told);  // over both
  CHECK(state_of(15.0, 0.0, limits) == StepState::passed);
  CHECK(state_of(15.1, 0.0, limits) == StepState::failed);
  CHECK(state_of(-1e9, 1.0, {.most = 1.0}) == StepState::passed);
}

TEST(GuardBand, OfSeveralNumbersTheFirstThatFailsCountsElseTheFirstThatIsNotTold) {
  const Limits limits = within(1.0);
  StepResult result = passed(1.0, {}, "", "");
  hold(result, {0.0, 0.5}, limits, "a", "mend a");
  CHECK(result.state == StepState::passed);
  hold(result, {0.9, 1.1}, limits, "b", "mend b", "look at b");
  hold(result, {0.9, 1.1}, limits, "c", "mend c");
  is_not_told("look at b; if it stays so: mend b", result);
  hold(result, {2.0, 3.0}, limits, "d", "mend d");
  hold(result, {2.0, 3.0}, limits, "e", "mend e");
  hold(result, {0.9, 1.1}, limits, "f", "mend f");
  CHECK(result.state == StepState::failed);
  CHECK_EQUAL("d", result.fault);
  CHECK_EQUAL("mend d", result.advice);
}

// Of rigs whose true value is at the limit as many pass as fail: 2.275 % of a normal beyond two sd. Five sd of a count of
// 20,000 are 105. Few measurements are as rarely wrong, by Student's t and chi squared.
TEST(GuardBand, AtTheLimitPassesAndFailsOnceInFortyFour) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise;
  constexpr int kRigs = 20'000, kExpected = 455, kFiveSd = 105;
  int passed[3] = {}, failed[3] = {};
  for (int rig = 0; rig < kRigs; ++rig) {
    Sample sample;
    for (int i = 0; i < 5; ++i) sample.add(10.0 + noise(random));
    const Interval found[3] = {interval(1.0 + noise(random), 1.0), sample.mean_interval(), sample.sd_interval()};
    const double limit[3] = {1.0, 10.0, 1.0};
    for (int kind = 0; kind < 3; ++kind) {
      const StepState state = held(found[kind], {.most = limit[kind]}).state;
      passed[kind] += state == StepState::passed;
      failed[kind] += state == StepState::failed;
    }
  }
  for (int kind = 0; kind < 3; ++kind) {
    DOUBLES_EQUAL(kExpected, passed[kind], kFiveSd);
    DOUBLES_EQUAL(kExpected, failed[kind], kFiveSd);
  }
}

TEST(GuardBand, OneMeasurementTellsNothingOfItsScatter) {
  Sample one;
  one.add(5.0);
  CHECK(held(one.mean_interval(), within(100.0)).state == StepState::not_told);
  CHECK(held(one.sd_interval(), {.most = 100.0}).state == StepState::not_told);
}
