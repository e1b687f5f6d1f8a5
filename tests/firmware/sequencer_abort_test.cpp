// Shots that must not go on: late, stopped, or with lines that fail.
#include <string>

#include "tests/support/sequencer_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

TEST_GROUP(SequencerAbort) {
  SequencerFixture bench;
  VirtualRig& rig = bench.rig;
  void expect_aborted(const char* why) {
    CHECK_EQUAL(1u, rig.shots.size());
    STRCMP_CONTAINS(why, bench.abort_reason().c_str());
    CHECK_EQUAL(1u, rig.count(EventKind::shot_aborted));
    CHECK_EQUAL(0u, rig.count(EventKind::shot_ended));
    CHECK_TRUE(rig.all_inactive());
  }

  static void press_estop_at_many_instants(const Rig& config, Duration from_start, Duration step) {
    for (int i = 0; i < 97; ++i) {
      SequencerFixture trial(config);
      const MonoTime pressed = trial.fire() + from_start + (step + nanoseconds(13)) * i;
      trial.rig.schedule({Input::estop, pressed, true});
      trial.play();
      CHECK_EQUAL(1u, trial.rig.shots.size());
      CHECK_EQUAL("the e-stop is pressed", trial.abort_reason());
      CHECK_TRUE(trial.rig.all_inactive());
      CHECK(trial.rig.sets.back().time < pressed + milliseconds(1));
      CHECK_EQUAL(2u, trial.rig.count(EventKind::estop));  // the first at the start: released
    }
  }
};

TEST(SequencerAbort, FollowsAFreezeWithoutABurst) {
  const MonoTime start = bench.fire();
  const MonoTime frozen = start + kFirstFlashAt + microseconds(3000) * 50 + milliseconds(1);
  rig.freeze(frozen, milliseconds(50));
  bench.play();
  expect_aborted("flash 51 would have been 48");  // it was due 2 ms into the freeze: 48 ms late
  for (const Event& event : rig.events)
    if (event.kind == EventKind::shot_aborted) CHECK(event.commanded == frozen + milliseconds(2));
  CHECK_EQUAL(51u, rig.instants(Output::strobes).size());
  CHECK(rig.instants(Output::strobes).back() < frozen);
  CHECK_FALSE(known(bench.shot().flashes[51].issue_end));
  CHECK_EQUAL(167u, bench.shot().flashes.size());
}

TEST(SequencerAbort, CountsTheLampsPauseFromTheEndOfTheCallThatFlashed) {
  SequencerFixture tight([] {
    Rig config = shipped_rig();
    config.plan.period = config.lamps.min_period;
    config.plan.exposure = milliseconds(400);
    return config;
  }());
  const MonoTime start = tight.fire();
  // The machine stands still within the call: the line may have changed as late as at its end.
  tight.rig.freeze(start + kFirstFlashAt + nanoseconds(200), microseconds(200));
  tight.play();
  STRCMP_CONTAINS("flash 1 would have come", tight.abort_reason().c_str());
}

TEST(SequencerAbort, ToleratesAndRecordsAFlashThatIsLateWithinTheLimit) {
  const MonoTime start = bench.fire();
  const MonoTime due = start + kFirstFlashAt + microseconds(3000) * 50;
  rig.freeze(due - microseconds(10), microseconds(1000));
  bench.play();
  CHECK(bench.shot().abort_reason.empty());
  const FlashRecord& late = bench.shot().flashes[50];
  CHECK_EQUAL(due, late.commanded);
  CHECK(late.issue_start - due >= microseconds(989));
  CHECK(known(late.observed_a));
  CHECK(bench.shot().flashes[51].issue_start - bench.shot().flashes[51].commanded < microseconds(1));
}

TEST(SequencerAbort, HoldsTheWidthOfALatePulse) {
  const MonoTime start = bench.fire();
  rig.freeze(start + kFirstFlashAt - microseconds(10), microseconds(1000));
  bench.play();
  CHECK(rig.instants(Output::strobes, false).at(0) - rig.instants(Output::strobes).at(0) >=
        bench.config.lamps.pulse);
}

TEST(SequencerAbort, FollowsLampLinesThatAFreezeKeptOn) {
  const MonoTime start = bench.fire();
  rig.freeze(start + kFirstFlashAt + microseconds(30), milliseconds(1));
  bench.play();
  expect_aborted("the lamps' lines were on for 1");
}

TEST(SequencerAbort, ComesBeforeALampThatHasNotRecharged) {
  Rig config = shipped_rig();
  config.plan.period = microseconds(1600);
  SequencerFixture fast(config);
  const MonoTime start = fast.fire();
  // 1.4 ms late is within the limit, but the next flash is then due after 0.2 ms.
  fast.rig.freeze(start + kFirstFlashAt + microseconds(1600) * 20 - microseconds(10), microseconds(1410));
  fast.play();
  STRCMP_CONTAINS("flash 21 would have come", fast.abort_reason().c_str());
  CHECK_EQUAL(21u, fast.rig.instants(Output::strobes).size());
}

TEST(SequencerAbort, FollowsTheEStopWithinAMillisecondAtAnyInstant) {
  // Across the whole shot, in steps that are no divisor of the period, so that spins and pulses are hit too.
  press_estop_at_many_instants(shipped_rig(), {}, microseconds(5791));
}

TEST(SequencerAbort, FollowsTheKeyAndTheDisarmCommand) {
  MonoTime start = bench.fire();
  rig.schedule({Input::key, start + milliseconds(100), false});
  bench.play();
  expect_aborted("the key is off");
  const Event& key = *rig.find(EventKind::key, 1);  // the first told that it is on
  CHECK(key.line == Line::key && key.level == 0 && key.shot_id == 1);
  CHECK(key.device_time == start + milliseconds(100));

  SequencerFixture other;
  start = other.fire();
  other.rig.schedule_command(start + milliseconds(100), other.plain_command(CommandKind::disarm));
  other.play();
  CHECK_EQUAL("disarmed by command", other.abort_reason());
}

TEST(SequencerAbort, ReadsTheEStopAgainJustBeforeTheTrigger) {
  // Pressed within the spin before the trigger, so that its edge has not been read when the trigger is due.
  const MonoTime start = bench.fire();
  rig.schedule({Input::estop, start - microseconds(50), true});
  rig.schedule({Input::sensor_a, start - microseconds(190), true});  // the loop has just looked
  bench.play();
  expect_aborted("the e-stop is pressed");
  CHECK_EQUAL(0u, rig.instants(Output::trigger).size());
}

TEST(SequencerAbort, WithholdsATriggerThatWouldBeLate) {
  const MonoTime start = bench.fire();
  rig.freeze(start - milliseconds(1), milliseconds(20));
  bench.play();
  expect_aborted("trigger would have been 19");
  CHECK_EQUAL(0u, rig.instants(Output::trigger).size());
}

TEST(SequencerAbort, WithholdsTheTriggerWhenTheKeyCannotBeRead) {
  const MonoTime start = bench.fire();
  while (rig.time < start - milliseconds(10)) bench.sequencer.step(start - milliseconds(10));
  rig.levels_readable = false;
  bench.play();
  CHECK_EQUAL(0u, rig.instants(Output::trigger).size());
  CHECK_TRUE(rig.all_inactive());
  CHECK_FALSE(bench.shot().abort_reason.empty());
}

TEST(SequencerAbort, FollowsALineThatCannotBeSet) {
  int pulses = 0;
  rig.set_succeeds = [&pulses](Output output, bool active) {
    return !(output == Output::strobes && active && ++pulses == 30);
  };
  bench.shoot();
  expect_aborted("the lamps' lines could not be set");
  CHECK_EQUAL(29u, rig.instants(Output::strobes).size());
  CHECK_EQUAL(State::fault, bench.sequencer.state());  // until somebody has looked, and says so
  CHECK_EQUAL("an output line could not be set", std::string(rig.find(EventKind::fault)->detail.view()));
  bench.give(bench.plain_command(CommandKind::clear));
  CHECK_EQUAL(State::idle, bench.sequencer.state());
}

TEST(SequencerAbort, EndsTheLoopWhenALineCannotBeSwitchedOff) {
  bench.fire();
  rig.set_succeeds = [](Output output, bool active) { return output != Output::trigger || active; };
  bool goes_on = true;
  for (int turn = 0; goes_on && turn < 1'000'000; ++turn) goes_on = bench.step();
  CHECK_FALSE(goes_on);
  CHECK_EQUAL(1u, rig.count(EventKind::fault));
  CHECK_FALSE(bench.sequencer.stop("an output could not be switched off"));
  CHECK_EQUAL(1u, rig.shots.size());  // the record is handed over all the same
}

TEST(SequencerAbort, FollowsTheEStopWithinAMillisecondAtAnyInstantOfACodedTrain) {
  // The two lamps in turn, as close to one another as a plan may have them: the loop spins most of the time.
  Rig config = shipped_rig();
  const Duration gap = config.tolerance.spin + config.lamps.max_on + microseconds(1);
  config.lamps.min_period = gap * 2;
  config.plan.exposure = milliseconds(60);
  config.plan.impact_at = milliseconds(30);
  for (int k = 0; k < 100; ++k) config.plan.code.push_back({gap * k, k % 2 == 0 ? Lamps::a : Lamps::b});
  press_estop_at_many_instants(config, milliseconds(310 - 30), microseconds(431));
}

TEST(SequencerAbort, LatchesAFaultWhenTheInputsAreGone) {
  const MonoTime start = bench.fire();
  while (rig.time < start + milliseconds(100)) bench.step();
  rig.edges_readable = rig.levels_readable = false;
  rig.set_succeeds = [](Output, bool) { return false; };
  CHECK_FALSE(bench.step());
  CHECK_EQUAL(1u, rig.count(EventKind::shot_aborted));
  CHECK_EQUAL(1u, rig.count(EventKind::fault));
  CHECK_FALSE(bench.sequencer.stop("an output could not be switched off"));
  CHECK_EQUAL(1u, rig.shots.size());
}

TEST(SequencerAbort, LimitsEveryOutputsOnTimeWhateverThePlanSays) {
  // A rig and a plan that the checks would have refused: the outputs' own limits hold all the same.
  Rig config = shipped_rig();
  config.lamps.pulse = milliseconds(2);
  config.machine.pulse = milliseconds(5000);
  config.shutter.max_open = milliseconds(100);
  SequencerFixture wild(config);
  wild.shoot();
  const auto longest = [&wild](Output output) {
    const auto on = wild.rig.instants(output), off = wild.rig.instants(output, false);
    Duration result{};
    for (std::size_t k = 0; k < on.size(); ++k) result = std::max(result, off.at(k) - on[k]);
    return result;
  };
  const Duration cost = microseconds(1);
  CHECK(longest(Output::strobes) <= config.lamps.max_on + cost);
  CHECK(longest(Output::trigger) <= config.machine.max_on + config.lamps.max_on + cost);
  CHECK(longest(Output::shutter) <= config.shutter.max_open + config.lamps.max_on + cost);
}

TEST(SequencerAbort, HandsTheShotOverWhenTheDaemonIsStopped) {
  const MonoTime start = bench.fire();
  while (rig.time < start + milliseconds(100)) bench.step();
  bench.sequencer.stop("stopped by a signal");
  expect_aborted("stopped by a signal");
  CHECK_EQUAL(EventKind::stopped, rig.events.back().kind);
  CHECK(rig.statuses.back().state != State::firing);
  CHECK_EQUAL(rig.events.size() + rig.statuses.size(), rig.flushed);
}

TEST(SequencerAbort, StillCollectsTheLastFlashsLight) {
  const MonoTime start = bench.fire();
  rig.lamp_delay = microseconds(400);
  rig.schedule({Input::estop, start + kFirstFlashAt + microseconds(300), true});
  bench.play();
  CHECK(known(bench.shot().flashes[0].observed_a));
}
