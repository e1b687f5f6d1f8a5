// What dry trains say of lamps and sensors, good and bad.
#include "host/commission/electrical/lamp_judgement.hpp"

#include <cmath>
#include <string>

#include "tests/host/commission/trains.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using commission_test::train;
using commission_test::TrainFaults;

std::string fault_alone(const TrainFaults& faults, Lamps lamp = Lamps::a) {
  return judge_lamp_alone("lamp", lamp, train(lamp, faults), {}).fault;
}

}  // namespace

TEST_GROUP(LampJudgement){};

TEST(LampJudgement, MeasuresTheDelayOfAGoodLamp) {
  for (const Lamps lamp : {Lamps::a, Lamps::b}) {
    const StepResult result = judge_lamp_alone("lamp", lamp, train(lamp, {}), {});
    CHECK_TRUE_TEXT(result.state == StepState::passed, result.words.c_str());
    // The line changed within a call of 1.5 us: at its middle, give or take 0.43 us (rectangular).
    DOUBLES_EQUAL(12.0 - 0.75, *result.value, 0.4);
    DOUBLES_EQUAL(std::hypot(1.5 / std::sqrt(12.0), 0.1), *result.sd, 0.03);
  }
}

TEST(LampJudgement, InventsNothingOnAThousandGoodLamps) {
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    const StepResult result = judge_lamp_alone("lamp", Lamps::a, train(Lamps::a, {}, seed), {});
    CHECK_TRUE_TEXT(result.state == StepState::passed, result.words.c_str());
  }
}

TEST(LampJudgement, KnowsThatALongCallLeavesTheDelayOpen) {
  CHECK_EQUAL("", fault_alone({.call_us = 12.0}));
  CHECK_EQUAL("delay_off", fault_alone({.delay_us = 40.0, .call_us = 12.0}));
}

TEST(LampJudgement, NamesEachFault) {
  CHECK_EQUAL("lamp_dark", fault_alone({.dark = true}));
  CHECK_EQUAL("sensors_swapped", fault_alone({.swapped = true}));
  CHECK_EQUAL("sensors_swapped", fault_alone({.swapped = true}, Lamps::b));
  CHECK_EQUAL("lamp_weak", fault_alone({.missing_every = 50}));
  CHECK_EQUAL("lamp_weak", fault_alone({.missing_every = 3}));
  CHECK_EQUAL("cross_talk", fault_alone({.cross_talk_every = 30}));
  CHECK_EQUAL("double_flashes", fault_alone({.double_every = 40}));
  CHECK_EQUAL("late_flashes", fault_alone({.late_every = 40}));
  CHECK_EQUAL("jitter", fault_alone({.jitter_us = 9.0}));
  CHECK_EQUAL("delay_off", fault_alone({.delay_us = 18.0}));
  CHECK_EQUAL("delay_off", fault_alone({.delay_us = 7.0}));
}

TEST(LampJudgement, SaysWhatToWriteIntoTheRigFile) {
  const StepResult result = judge_lamp_alone("lamp", Lamps::b, train(Lamps::b, {.delay_us = 30.0}), {});
  CHECK_TRUE_TEXT(result.advice.find("delay_b_us = 29.") != std::string::npos, result.advice.c_str());
}

TEST(LampJudgement, LeavesOutALampWhoseSensorIsNotFitted) {
  auto shot = train(Lamps::b, {});
  shot.sensor_b_fitted = 0;
  CHECK_TRUE(judge_lamp_alone("lamp", Lamps::b, shot, {}).state == StepState::skipped);
  CHECK_TRUE(judge_lamps_together("both", shot, {}).state == StepState::skipped);
}

TEST(LampJudgement, HoldsLampsTogetherAgainstTheirSkew) {
  const StepResult good = judge_lamps_together("both", train(Lamps::both, {}), {});
  CHECK_TRUE_TEXT(good.state == StepState::passed, good.words.c_str());
  DOUBLES_EQUAL(-0.1, *good.value, 0.6);  // four sds of the mean of a hundred: 4 x 1.4 us / 10
  auto late = train(Lamps::both, {});
  for (auto& flash : late.flashes) flash.observed_b_ns += 9'000;
  CHECK_EQUAL("skew", judge_lamps_together("both", late, {}).fault);
  auto weak = train(Lamps::both, {});
  weak.flashes[17].observed_b_ns = strobe_msgs::flash_t::NO_TIME;
  CHECK_EQUAL("lamp_weak_together", judge_lamps_together("both", weak, {}).fault);
}
