#include "firmware/core/pulse_schedule.hpp"

#include <string>

#include "tests/support/virtual_rig.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(PulseScheduleOfAPlan) {
  Rig rig = strobe::testing::shipped_rig();
  ShotPlan request = rig.plan;
  PulseSchedule plan;

  void setup() override { plan.reserve(rig.lamps.max_flashes); }
  const PlannedPulse* first(Output output) {
    for (const PlannedPulse& pulse : plan.pulses)
      if (pulse.output == output) return &pulse;
    return nullptr;
  }
  std::string refusal() {
    const auto checked = check_plan(request, rig);
    return checked ? "" : checked.error().message;
  }
  void gated(int flashes) {
    request.train = Train::gated;
    request.flash_count = flashes;
  }
};

TEST(PulseScheduleOfAPlan, FlashesFromTheShuttersOpeningToItsClosing) {
  build_schedule(request, rig, plan);
  // 500 ms / 3 ms = 166.7: the 167th flash is at 498 ms, the next would be at 501 ms.
  CHECK_EQUAL(167, plan.flash_count);
  CHECK_EQUAL(plan.exposure_begin, first(Output::strobes)->at);
  CHECK_EQUAL(milliseconds(500), plan.exposure_end - plan.exposure_begin);
  CHECK_EQUAL(rig.shutter.lag, plan.exposure_begin - first(Output::shutter)->at);
  CHECK_EQUAL(milliseconds(500), first(Output::shutter)->width);
}

TEST(PulseScheduleOfAPlan, TimesTheTriggerSoThatTheBallIsAtThePlateAsAsked) {
  build_schedule(request, rig, plan);
  const Duration ball_at_plate = first(Output::trigger)->at + rig.machine.lag;
  CHECK_EQUAL(milliseconds(250), ball_at_plate - plan.exposure_begin);
}

TEST(PulseScheduleOfAPlan, StartsWithTheEarliestPulseWhicheverItIs) {
  build_schedule(request, rig, plan);
  CHECK_EQUAL(Output::trigger, plan.pulses.front().output);
  CHECK_EQUAL(Duration{}, plan.pulses.front().at);
  request.impact_at = milliseconds(400);
  build_schedule(request, rig, plan);
  CHECK_EQUAL(Output::shutter, plan.pulses.front().output);
  CHECK_EQUAL(Duration{}, plan.pulses.front().at);
  CHECK_EQUAL(milliseconds(45 + 400 - 310), first(Output::trigger)->at);
}

TEST(PulseScheduleOfAPlan, TakesTheRigFilesImpactWhereTheRequestHasNone) {
  request.impact_at = {};
  build_schedule(request, rig, plan);
  CHECK_EQUAL(rig.plan.impact_at, first(Output::trigger)->at + rig.machine.lag - plan.exposure_begin);
}

TEST(PulseScheduleOfAPlan, HasNoTriggerInADryShot) {
  request.dry = true;
  build_schedule(request, rig, plan);
  POINTERS_EQUAL(nullptr, first(Output::trigger));
  CHECK_EQUAL(Duration{}, first(Output::shutter)->at);
}

TEST(PulseScheduleOfAPlan, IsSortedByInstant) {
  build_schedule(request, rig, plan);
  for (std::size_t i = 1; i < plan.pulses.size(); ++i) CHECK(plan.pulses[i - 1].at <= plan.pulses[i].at);
}

TEST(PulseScheduleOfAPlan, HasNoFlashesInAGatedShotUntilTheGateIsSeen) {
  gated(5);
  CHECK_EQUAL(std::string(), refusal());
  build_schedule(request, rig, plan);
  POINTERS_EQUAL(nullptr, first(Output::strobes));
  CHECK(add_burst(request, rig, plan.exposure_begin + milliseconds(100), plan));
  CHECK_EQUAL(5u + 2u, plan.pulses.size());
  CHECK_EQUAL(plan.exposure_begin + milliseconds(100), first(Output::strobes)->at);
}

TEST(PulseScheduleOfAPlan, AddsNoBurstThatWouldOutlastTheExposure) {
  gated(5);
  build_schedule(request, rig, plan);
  const Duration burst = request.period * 4 + rig.lamps.pulse;
  CHECK_FALSE(add_burst(request, rig, plan.exposure_end - burst + nanoseconds(1), plan));
  CHECK_EQUAL(2u, plan.pulses.size());
  CHECK(add_burst(request, rig, plan.exposure_end - burst, plan));
}

TEST(PulseScheduleOfAPlan, RefusesAPeriodShorterThanTheLampsRecharge) {
  request.period = rig.lamps.min_period - nanoseconds(1);
  STRCMP_CONTAINS("shorter than the lamps'", refusal().c_str());
  request.period = rig.lamps.min_period;
  request.exposure = milliseconds(400);
  CHECK_EQUAL(std::string(), refusal());
}

TEST(PulseScheduleOfAPlan, RefusesMoreFlashesThanAShotMayHave) {
  request.period = rig.lamps.min_period;
  request.exposure = rig.lamps.min_period * rig.lamps.max_flashes;
  CHECK_EQUAL(std::string(), refusal());
  request.exposure = request.exposure + nanoseconds(1);
  STRCMP_CONTAINS("401 flashes are more than the 400", refusal().c_str());
}

TEST(PulseScheduleOfAPlan, RefusesAnExposureLongerThanTheShutterStands) {
  request.period = microseconds(10'000);
  request.exposure = rig.shutter.max_open + nanoseconds(1);
  STRCMP_CONTAINS("longer than the shutter's 2000 ms", refusal().c_str());
}

TEST(PulseScheduleOfAPlan, RefusesABallThatComesAfterTheExposure) {
  request.impact_at = request.exposure;
  STRCMP_CONTAINS("after the shutter opened", refusal().c_str());
}

TEST(PulseScheduleOfAPlan, RefusesAGatedTrainWithoutAGateOrABurst) {
  gated(0);
  STRCMP_CONTAINS("flash_count of at least 1", refusal().c_str());
  gated(5);
  rig.line(Line::gate).fitted = false;
  STRCMP_CONTAINS("lines.gate", refusal().c_str());
}

TEST(PulseScheduleOfAPlan, RefusesABurstLongerThanTheExposure) {
  gated(167);
  CHECK_EQUAL(std::string(), refusal());
  gated(168);
  STRCMP_CONTAINS("longer than the exposure", refusal().c_str());
  gated(5);
  request.gate_delay = request.impact_at = milliseconds(1);
  request.exposure = request.gate_delay + request.period * 4 + rig.lamps.pulse;
  CHECK_EQUAL(std::string(), refusal());
  request.exposure = request.exposure - nanoseconds(1);
  STRCMP_CONTAINS("longer than the exposure", refusal().c_str());
}

TEST(PulseScheduleOfAPlan, RefusesNumbersThatNoRigHas) {
  const std::int64_t extremes[] = {INT64_MIN, -1, INT64_MAX};
  for (const std::int64_t extreme : extremes) {
    for (Duration ShotPlan::*field :
         {&ShotPlan::period, &ShotPlan::exposure, &ShotPlan::gate_delay, &ShotPlan::impact_at}) {
      request = rig.plan;
      request.*field = nanoseconds(extreme);
      CHECK(!refusal().empty());
    }
  }
  request = rig.plan;
  request.train = static_cast<Train>(7);
  STRCMP_CONTAINS("unknown kind of train", refusal().c_str());
}
