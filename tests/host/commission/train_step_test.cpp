// What dry trains say of lamps and sensors, good and bad, and of the shutter by its contact.
#include "host/commission/train_step.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "tests/host/commission/judged.hpp"
#include "tests/host/commission/trains.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using commission_test::is_not_told;
using commission_test::train;
using commission_test::TrainFaults;

std::string fault_alone(const TrainFaults& faults, Lamps lamp = Lamps::a) {
  return judge_lamp_alone(lamp, train(lamp, faults), {}).fault;
}

using strobe_msgs::shot_t;

std::vector<shot_t> shots(double opens_ms, double closes_ms, std::int8_t feedback = shot_t::FEEDBACK_SEEN) {
  std::vector<shot_t> made;
  for (int k = 0; k < 5; ++k) {
    const double spread_ms = 0.1 * (k - 2);
    shot_t shot{};
    shot.shutter_feedback = feedback;
    shot.shutter_on_ns = 1'000'000'000LL * (k + 1);
    shot.shutter_off_ns = shot.shutter_on_ns + 150'000'000;
    shot.shutter_open_ns = shot.shutter_on_ns + static_cast<std::int64_t>(1e6 * (opens_ms + spread_ms));
    shot.shutter_close_ns = shot.shutter_off_ns + static_cast<std::int64_t>(1e6 * (closes_ms + spread_ms));
    made.push_back(shot);
  }
  return made;
}

}  // namespace

TEST_GROUP(LampJudgement){};

TEST(LampJudgement, MeasuresTheDelayOfAGoodLamp) {
  for (const Lamps lamp : {Lamps::a, Lamps::b}) {
    const StepResult result = judge_lamp_alone(lamp, train(lamp, {}), {});
    CHECK_TRUE_TEXT(result.state == StepState::passed, result.words.c_str());
    // The line changed within a call of 1.5 us: at its middle, give or take 0.43 us (rectangular).
    DOUBLES_EQUAL(12.0 - 0.75, *result.value, 0.4);
    DOUBLES_EQUAL(std::hypot(1.5 / std::sqrt(12.0), 0.1), *result.sd, 0.03);
  }
}

TEST(LampJudgement, InventsNothingOnAThousandGoodLamps) {
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    const StepResult result = judge_lamp_alone(Lamps::a, train(Lamps::a, {}, seed), {});
    CHECK_TRUE_TEXT(result.state == StepState::passed, result.words.c_str());
  }
}

// Calls of 12 us leave the delay open by 6 / sqrt(3) us: more than half the tolerance of 3.
TEST(LampJudgement, KnowsThatALongCallLeavesTheDelayOpen) {
  is_not_told("the calls that set the line take 12 us",
              judge_lamp_alone(Lamps::a, train(Lamps::a, {.call_us = 12.0}), {}));
  is_not_told("the calls that set the line take 12 us",
              judge_lamp_alone(Lamps::a, train(Lamps::a, {.delay_us = 18.0, .call_us = 12.0}), {}));
  CHECK_EQUAL("delay_off", fault_alone({.delay_us = 40.0, .call_us = 12.0}));
}

// Of a hundred flashes an sd is known to 7 %.
TEST(LampJudgement, DoesNotTellAJitterThatIsAtItsLimit) {
  host::CommissionTable limits;
  limits.delay_tolerance_us = 5.0;
  is_not_told("take more shots", judge_lamp_alone(Lamps::a, train(Lamps::a, {.jitter_us = 5.0}), limits));
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
  const StepResult result = judge_lamp_alone(Lamps::b, train(Lamps::b, {.delay_us = 30.0}), {});
  CHECK_TRUE_TEXT(result.advice.find("delay_b_us = 29.") != std::string::npos, result.advice.c_str());
}

TEST(LampJudgement, LeavesOutALampWhoseSensorIsNotFitted) {
  auto shot = train(Lamps::b, {});
  shot.sensor_b_fitted = 0;
  CHECK_TRUE(judge_lamp_alone(Lamps::b, shot, {}).state == StepState::skipped);
  CHECK_TRUE(judge_lamps_together(shot, {}).state == StepState::skipped);
}

TEST(LampJudgement, HoldsLampsTogetherAgainstTheirSkew) {
  const StepResult good = judge_lamps_together(train(Lamps::both, {}), {});
  CHECK_TRUE_TEXT(good.state == StepState::passed, good.words.c_str());
  DOUBLES_EQUAL(-0.1, *good.value, 0.6);  // four sds of the mean of a hundred: 4 x 1.4 us / 10
  auto late = train(Lamps::both, {});
  for (auto& flash : late.flashes) flash.observed_b_ns += 9'000;
  CHECK_EQUAL("skew", judge_lamps_together(late, {}).fault);
  auto weak = train(Lamps::both, {});
  weak.flashes[17].observed_b_ns = strobe_msgs::flash_t::NO_TIME;
  CHECK_EQUAL("lamp_weak_together", judge_lamps_together(weak, {}).fault);
}

TEST_GROUP(ShutterJudgement) {
  host::RigFile rig = *host::read_rig("rig = \"bench\"\n[shutter]\nlag_ms = 45\n", "rig.toml");
};

TEST(ShutterJudgement, MeasuresTheLagOfAGoodShutter) {
  const StepResult result = judge_shutter(shots(45.5, 44.0), rig);
  CHECK_TRUE_TEXT(result.state == StepState::passed, result.words.c_str());
  DOUBLES_EQUAL(45.5, *result.value, 1e-6);
  DOUBLES_EQUAL(0.1 * std::sqrt(2.5 / 5.0), *result.sd, 1e-6);
}

TEST(ShutterJudgement, NamesAShutterThatIsLateEarlyOrStuck) {
  CHECK_EQUAL("shutter_late", judge_shutter(shots(53.0, 45.0), rig).fault);
  CHECK_EQUAL("shutter_late", judge_shutter(shots(45.0, 53.0), rig).fault);
  CHECK_EQUAL("shutter_early", judge_shutter(shots(30.0, 45.0), rig).fault);
  CHECK_EQUAL("shutter_late", judge_shutter(shots(90.0, 90.0, shot_t::FEEDBACK_LATE), rig).fault);
  CHECK_EQUAL("shutter_stuck", judge_shutter(shots(45.0, 45.0, shot_t::FEEDBACK_MISSING), rig).fault);
}

// Five lags of 0.1 ms sd .16: their mean is known to 2.87 times .07 ms (Student's t of four degrees of freedom).
TEST(ShutterJudgement, DoesNotTellALagAtItsLimit) {
  is_not_told("take more shots", judge_shutter(shots(47.9, 45.0), rig));
  is_not_told("take more shots", judge_shutter(shots(45.0, 41.9), rig));
  CHECK_TRUE(judge_shutter(shots(47.7, 42.3), rig).state == StepState::passed);
}

TEST(ShutterJudgement, IsLeftOutWithoutAContact) {
  CHECK_TRUE(judge_shutter(shots(45.0, 45.0, shot_t::FEEDBACK_NONE), rig).state == StepState::skipped);
}
