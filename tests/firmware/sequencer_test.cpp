#include "firmware/core/sequencer.hpp"

#include <string>

#include "tests/support/allocations.hpp"
#include "tests/support/sequencer_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

namespace {
// One reading of the virtual clock and one overshoot of a spin: nothing else delays a pulse there.
constexpr Duration kIssueCost = nanoseconds(100);
}  // namespace

TEST_GROUP(Sequencer) {
  SequencerFixture bench;
  VirtualRig& rig = bench.rig;
  std::string refusal() {
    const Event* event = rig.find(EventKind::refused, rig.count(EventKind::refused) - 1);
    return event ? std::string(event->detail.view()) : "";
  }
};

TEST(Sequencer, MakesTheOutputsInactiveBeforeAnythingElse) {
  CHECK_EQUAL(3u, rig.sets.size());
  for (const auto& set : rig.sets) CHECK_FALSE(set.active);
  CHECK_EQUAL(Output::trigger, rig.sets.front().output);
  CHECK_EQUAL(EventKind::started, rig.events.front().kind);
  CHECK_EQUAL(1u, rig.statuses.size());
  CHECK_EQUAL(rig.events.size() + 1, rig.flushed);
}

TEST(Sequencer, PlaysEveryFlashAtItsInstant) {
  const MonoTime start = bench.shoot();
  const auto flashes = rig.instants(Output::strobes);
  CHECK_EQUAL(167u, flashes.size());
  for (std::size_t k = 0; k < flashes.size(); ++k) {
    const MonoTime due = start + kFirstFlashAt + microseconds(3000) * static_cast<std::int64_t>(k);
    CHECK(flashes[k] >= due);
    CHECK(flashes[k] <= due + kIssueCost);
  }
}

TEST(Sequencer, EndsEachPulseAfterItsWidth) {
  const MonoTime start = bench.shoot();
  const auto on = rig.instants(Output::strobes), off = rig.instants(Output::strobes, false);
  CHECK_EQUAL(on.size(), off.size());
  for (std::size_t k = 0; k < on.size(); ++k) {
    CHECK(off[k] - on[k] >= bench.config.lamps.pulse);
    CHECK(off[k] - on[k] <= bench.config.lamps.pulse + rig.set_cost + kIssueCost);
  }
  const Duration trigger = rig.instants(Output::trigger, false).at(0) - rig.instants(Output::trigger).at(0);
  CHECK(trigger >= bench.config.machine.pulse);
  CHECK(trigger <= bench.config.machine.pulse + rig.set_cost + kIssueCost);
  CHECK(rig.instants(Output::trigger).at(0) - start <= kIssueCost);
  CHECK(rig.instants(Output::shutter).at(0) - (start + kShutterAt) <= kIssueCost);
}

TEST(Sequencer, HandsOverAWholeRecord) {
  const MonoTime start = bench.shoot();
  CHECK_EQUAL(1u, rig.shots.size());
  const ShotRecord& shot = bench.shot();
  CHECK(shot.abort_reason.empty());
  CHECK_EQUAL(start, shot.start);
  CHECK_EQUAL(kHost, shot.host_id);
  CHECK_EQUAL(bench.last_command, shot.command_id);
  CHECK_EQUAL(1, shot.shot_id);
  CHECK_EQUAL(167u, shot.flashes.size());
  for (const FlashRecord& flash : shot.flashes) {
    CHECK(flash.issue_start >= flash.commanded);
    CHECK(flash.issue_end > flash.issue_start);
    CHECK(flash.observed_a - flash.issue_start <= rig.lamp_delay + kIssueCost);
    CHECK_EQUAL(flash.observed_a, flash.observed_b);
    CHECK_EQUAL(0, flash.extra_edges);
  }
  CHECK(shot.shutter_close - shot.shutter_open >= milliseconds(500));
  CHECK(known(shot.trigger));
}

TEST(Sequencer, SubtractsTheSensorsDelay) {
  Rig config = shipped_rig();
  config.sensors.delay_a = config.sensors.delay_b = microseconds(5);
  SequencerFixture slow(config);
  slow.shoot();
  const FlashRecord& flash = slow.shot().flashes[3];
  CHECK(flash.observed_a - flash.issue_start <= slow.rig.lamp_delay - microseconds(5) + kIssueCost);
}

TEST(Sequencer, ReportsTheShotInOrder) {
  bench.shoot();
  CHECK_EQUAL(1u, rig.count(EventKind::shot_started));
  CHECK_EQUAL(167u, rig.count(EventKind::flash));
  CHECK_EQUAL(334u, rig.count(EventKind::sensor));
  CHECK_EQUAL(2u, rig.count(EventKind::trigger));
  CHECK_EQUAL(2u, rig.count(EventKind::shutter));
  CHECK_EQUAL(EventKind::shot_ended, rig.events.back().kind);
  int index = 0;
  for (const Event& event : rig.events) {
    if (event.kind != EventKind::flash) continue;
    CHECK_EQUAL(index, event.flash_index);
    ++index;
    CHECK_EQUAL(1, event.shot_id);
    CHECK_EQUAL(event.issue_end, event.device_time);
  }
  const FlashRecord& flash = bench.shot().flashes[0];
  const Event& told = *rig.find(EventKind::flash);
  CHECK(told.commanded == flash.commanded && told.issue_start == flash.issue_start);
  CHECK(told.issue_end == flash.issue_end);
  const Event& seen = *rig.find(EventKind::sensor);
  CHECK(seen.line == Line::sensor_a && seen.device_time == flash.observed_a);
  CHECK(rig.find(EventKind::sensor, 1)->line == Line::sensor_b);
  for (const EventKind kind : {EventKind::trigger, EventKind::shutter}) {
    CHECK_EQUAL(1, rig.find(kind, 0)->level);
    CHECK_EQUAL(0, rig.find(kind, 1)->level);
    CHECK(rig.find(kind)->line == (kind == EventKind::trigger ? Line::trigger : Line::shutter));
  }
}

TEST(Sequencer, LeavesTheMachineAloneInADryShot) {
  bench.shoot(true);
  CHECK_EQUAL(0u, rig.instants(Output::trigger).size());
  CHECK_EQUAL(167u, rig.instants(Output::strobes).size());
  CHECK_EQUAL("dry", std::string(rig.find(EventKind::shot_started)->detail.view()));
}

TEST(Sequencer, AllocatesNothingWhileItPlaysAShot) {
  const std::int64_t token = bench.arm();
  rig.schedule_command(rig.time, bench.fire_command(token));
  std::int64_t allocated = 0;
  {
    const AllocationCounter allocations;
    bench.play();
    allocated = allocations.count();
  }
  CHECK_EQUAL(0, allocated);
  CHECK_EQUAL(1u, rig.shots.size());
}

TEST(Sequencer, NumbersShotsFromTheLastOneOfTheSession) {
  SequencerFixture later;
  Sequencer sequencer(later.config, later.rig.ports(later.outputs), 41);
  sequencer.start("test");
  later.rig.schedule_command(later.rig.time, later.arm_command());
  sequencer.step(kNoDeadline);
  later.rig.schedule_command(later.rig.time, later.fire_command(later.rig.statuses.back().arm_token));
  sequencer.step(kNoDeadline);
  CHECK_EQUAL(42, later.rig.statuses.back().last_shot_id);
}

TEST(Sequencer, FiresAgainAfterANewArming) {
  bench.shoot();
  bench.shoot();
  CHECK_EQUAL(2u, rig.instants(Output::trigger).size());
  CHECK_EQUAL(2, bench.shot(1).shot_id);
}

TEST(Sequencer, RefusesAFireThatIsPlayedBack) {
  const std::int64_t token = bench.arm();
  const Command fire = bench.fire_command(token);
  bench.give(fire);
  bench.play();
  bench.give(fire);
  bench.play();
  CHECK_EQUAL(1u, rig.instants(Output::trigger).size());
  CHECK_EQUAL("FIRE: the arming is spent: arm again", refusal());
}

TEST(Sequencer, RefusesAWrongToken) {
  bench.give(bench.fire_command(bench.arm() + 1));
  CHECK_EQUAL("FIRE: the token is not that of the arming", refusal());
  CHECK_EQUAL(0u, rig.count(EventKind::shot_started));
}

TEST(Sequencer, RefusesWhatTheReceiverFoundWrong) {
  Command fire = bench.fire_command(bench.arm());
  fire.defect = "a repeated command";
  bench.give(fire);
  CHECK_EQUAL("FIRE: a repeated command", refusal());
  CHECK_EQUAL(State::armed, bench.sequencer.state());
}

TEST(Sequencer, RefusesToArmWithTheKeyOff) {
  rig.key = false;
  bench.give(bench.arm_command());
  CHECK_EQUAL("ARM: the key is off", refusal());
  CHECK_EQUAL(0, rig.statuses.back().arm_token);
}

TEST(Sequencer, RefusesWhileTheJournalCannotBeWritten) {
  const std::int64_t token = bench.arm();
  rig.journal = false;
  bench.give(bench.fire_command(token));
  CHECK_EQUAL("FIRE: the journal cannot be written", refusal());
  bench.give(bench.arm_command());
  CHECK_EQUAL("ARM: the journal cannot be written", refusal());
}

TEST(Sequencer, FiresNoShotWhoseNumberIsNotSetAside) {
  rig.last_number = 1;
  bench.shoot();
  const std::string none = "no number is set aside for the shot yet";
  bench.give(bench.arm_command());
  CHECK_EQUAL("ARM: " + none, refusal());
  rig.last_number = 2;
  const std::int64_t token = bench.arm();
  rig.last_number = 1;
  bench.give(bench.fire_command(token));
  CHECK_EQUAL("FIRE: " + none, refusal());
  rig.last_number = 2;
  bench.give(bench.fire_command(token));
  bench.play();
  CHECK_EQUAL(2, bench.shot(1).shot_id);
}

TEST(Sequencer, FiresNoBallAtLampsThatHaveNotRechargedSinceTheStartOrTheShotBefore) {
  Rig config = shipped_rig();
  config.lamps.min_period = config.plan.period = milliseconds(490);
  SequencerFixture slow(config);
  const MonoTime started = slow.rig.time;
  const auto last_refusal = [&slow] {
    return std::string(
        slow.rig.find(EventKind::refused, slow.rig.count(EventKind::refused) - 1)->detail.view());
  };
  const auto pass = [&slow](Duration time) {
    for (const MonoTime end = slow.rig.time + time; slow.rig.time < end;) slow.step();
  };
  // Whatever flashed before the start may have done so just then.
  const std::int64_t token = slow.arm();
  slow.give(slow.fire_command(token));
  // The first flash would come 20 ms (the lead) and 60 ms (the ball's way) later.
  STRCMP_CONTAINS("FIRE: the lamps have not recharged: again in 41", last_refusal().c_str());
  CHECK_EQUAL(0u, slow.rig.shots.size());
  pass(milliseconds(411));
  slow.give(slow.fire_command(token));  // the token is not spent
  slow.play();
  CHECK_EQUAL("", slow.abort_reason());
  slow.give(slow.fire_command(slow.arm()));
  STRCMP_CONTAINS("FIRE: the lamps have not recharged: again in ", last_refusal().c_str());
  pass(config.lamps.min_period);
  slow.shoot();
  CHECK_EQUAL("", slow.abort_reason(1));
  CHECK_EQUAL(2u, slow.rig.instants(Output::trigger).size());
  MonoTime last = started;
  for (const MonoTime flash : slow.rig.instants(Output::strobes)) {
    CHECK(flash - last >= config.lamps.min_period - config.tolerance.late);
    last = flash;
  }
}

TEST(Sequencer, WakesThePublisherForWhatTheTurnBeforeReported) {
  bench.arm();
  const std::size_t reported = rig.events.size() + rig.statuses.size();
  CHECK(rig.flushed < reported);
  bench.step();
  CHECK_EQUAL(reported, rig.flushed);
}

TEST(Sequencer, TellsWhoHasArmed) {
  Command arm = bench.arm_command();
  arm.host_id = 0x1f2e;
  bench.give(arm);
  CHECK_EQUAL("1f2e", std::string(rig.find(EventKind::armed)->detail.view()));
  rig.events.clear();
  arm.host_name = "anna@desk";
  bench.give(arm);
  CHECK_EQUAL("1f2e anna@desk", std::string(rig.find(EventKind::armed)->detail.view()));
}

TEST(Sequencer, LetsTheArmingExpireByItself) {
  bench.arm();
  const MonoTime armed = rig.time;
  while (bench.sequencer.state() == State::armed && rig.time < armed + milliseconds(40'000)) bench.step();
  CHECK(rig.time >= armed + milliseconds(29'999));
  CHECK(rig.time <= armed + milliseconds(30'000) + Sequencer::kLongestSleep);
  CHECK_EQUAL("the arming has expired", std::string(rig.find(EventKind::disarmed)->detail.view()));
}

TEST(Sequencer, ReadsTheLevelsBeforeItArmsOrFiresInCaseAnEdgeWasLost) {
  const std::int64_t token = bench.arm();
  rig.key = false;  // without an edge
  bench.give(bench.fire_command(token));
  CHECK_EQUAL(0u, rig.count(EventKind::shot_started));
  CHECK_EQUAL("FIRE: the key is off", refusal());
  rig.key = true;
  for (int turn = 0; turn < 3; ++turn) bench.step();
  bench.reset();
  bench.arm();
  rig.estop = true;
  bench.give(bench.arm_command());
  CHECK_EQUAL("ARM: the e-stop is pressed", refusal());
}

TEST(Sequencer, LeavesNothingOfAnEarlierShotInItsRecord) {
  rig.reuses_records = true;
  const MonoTime start = bench.fire();
  rig.schedule({Input::gate, start + milliseconds(200), true});
  while (rig.time < start + milliseconds(300)) bench.step();
  bench.give(bench.plain_command(CommandKind::disarm));
  bench.play();
  bench.reset();
  CHECK(known(bench.shot().trigger) && known(bench.shot().gate) && known(bench.shot().shutter_off));
  CHECK_FALSE(bench.shot().abort_reason.empty());
  bench.fire(true);
  CHECK(bench.shot().abort_reason.empty());
  CHECK_FALSE(known(bench.shot().trigger) || known(bench.shot().gate));
  CHECK_FALSE(known(bench.shot().shutter_on) || known(bench.shot().shutter_off));
  CHECK_FALSE(known(bench.shot().shutter_open) || known(bench.shot().shutter_close));
}

TEST(Sequencer, EndsAPulseItsWidthAfterTheLineHasSurelyChanged) {
  rig.set_cost = microseconds(30);
  bench.shoot();
  const auto on = rig.instants(Output::strobes), off = rig.instants(Output::strobes, false);
  for (std::size_t k = 0; k < on.size(); ++k)
    CHECK(off.at(k) - on[k] >= rig.set_cost + bench.config.lamps.pulse);
}

TEST(Sequencer, CountsTheOverflowsOfEachShotAlone) {
  rig.lost = 5;
  rig.kernel_lost = 7;
  const MonoTime start = bench.fire();
  while (rig.time < start + milliseconds(100)) bench.step();
  rig.lost += 2;
  rig.kernel_lost += 3;
  bench.play();
  bench.shoot();
  CHECK_EQUAL(2, bench.shot(0).queue_overflows);
  CHECK_EQUAL(3, bench.shot(0).kernel_overflows);
  CHECK_EQUAL(0, bench.shot(1).queue_overflows);
  CHECK_EQUAL(0, bench.shot(1).kernel_overflows);
  CHECK_EQUAL(10, rig.statuses.back().kernel_overflows);
}

TEST(Sequencer, NoticesAKeyWhoseEdgeWasLost) {
  bench.arm();
  rig.key = false;  // without an edge
  for (int turn = 0; turn < 3; ++turn) bench.step();
  CHECK_EQUAL(State::stopped, bench.sequencer.state());
  CHECK_EQUAL(1u, rig.count(EventKind::disarmed));
}

TEST(Sequencer, ArmsAfterAnEStopOnlyOnceAPersonHasResetIt) {
  rig.schedule({Input::estop, rig.time + milliseconds(1), true});
  rig.schedule({Input::estop, rig.time + milliseconds(90), false});
  const Command early = bench.reset_command();  // given before the e-stop was released
  for (int turn = 0; turn < 5; ++turn) bench.step();
  bench.give(bench.arm_command());
  CHECK_EQUAL("ARM: stopped: a person must give the command to fire anew", refusal());
  bench.give(early);
  CHECK_EQUAL("RESET: the rig was stopped, or key or e-stop moved, after this command was given: give it again",
              std::string(rig.find(EventKind::refused, 1)->detail.view()));
  bench.give(bench.reset_command());
  CHECK_EQUAL(1u, rig.count(EventKind::reset));
  bench.give(bench.arm_command());
  CHECK_EQUAL("ARM: a stop was reset just now", std::string(rig.find(EventKind::refused, 2)->detail.view()));
  bench.reset();
  bench.shoot();
  CHECK_EQUAL(1u, rig.instants(Output::trigger).size());
}

TEST(Sequencer, StaysStoppedAfterADisarmThoughNothingWasArmed) {
  Command disarm = bench.plain_command(CommandKind::disarm);
  disarm.host_name = "anna@desk";
  bench.give(disarm);
  CHECK_EQUAL("disarmed by command 1 of 4d anna@desk",
              std::string(rig.find(EventKind::disarmed)->detail.view()));
  disarm.command_id = 2;  // repeated until it is confirmed
  bench.give(disarm);
  CHECK_EQUAL("disarmed by command 2 of 4d anna@desk",
              std::string(rig.find(EventKind::disarmed, 1)->detail.view()));
  CHECK_EQUAL(0, bench.arm());
  CHECK_EQUAL(State::stopped, rig.statuses.back().state);
}

TEST(Sequencer, ObeysADisarmWhateverElseIsWrongWithIt) {
  bench.arm();
  Command disarm = bench.plain_command(CommandKind::disarm);
  disarm.defect = "schema version 9 instead of 2";
  bench.give(disarm);
  CHECK_EQUAL(State::stopped, bench.sequencer.state());
}

TEST(Sequencer, BeginsStoppedWhereTheKeyIsOff) {
  SequencerFixture off(shipped_rig(), {}, [](VirtualRig& at_start) { at_start.key = false; });
  off.rig.key = true;
  for (int turn = 0; turn < 3; ++turn) off.step();
  CHECK_EQUAL(0, off.arm());
  off.reset();
  CHECK(off.arm() != 0);
}

TEST(Sequencer, AbortsAShotInWhichTheMachineWasSuspended) {
  const MonoTime start = bench.fire();
  while (rig.time < start + milliseconds(100)) bench.step();
  rig.asleep = milliseconds(3'600'000);  // hours by every other clock
  bench.play();
  CHECK_EQUAL("the rig's computer was suspended", bench.abort_reason());
  CHECK_EQUAL(State::stopped, bench.sequencer.state());
}

TEST(Sequencer, PullsNoTriggerThatWasPendingWhenTheMachineWasSuspended) {
  const MonoTime start = bench.fire();
  while (rig.time < start - milliseconds(1)) bench.sequencer.step(start - milliseconds(1));
  rig.asleep = milliseconds(200);
  bench.play();
  CHECK_EQUAL(0u, rig.instants(Output::trigger).size());
}

TEST(Sequencer, DropsWhatIsArmedWhenTheMachineWasSuspended) {
  bench.arm();
  rig.asleep = milliseconds(60'000);
  bench.step();
  CHECK_EQUAL(State::stopped, bench.sequencer.state());
  CHECK_EQUAL("the rig's computer was suspended", std::string(rig.find(EventKind::disarmed)->detail.view()));
}

TEST(Sequencer, DropsWhatIsArmedWhenItStoodStillItself) {
  const std::int64_t token = bench.arm();
  const Command fire = bench.fire_command(token);
  rig.schedule_command(rig.time, fire);  // it has come, and is not looked at before
  rig.freeze(rig.time + nanoseconds(30), Sequencer::kStoodStill + milliseconds(1));
  bench.step();
  CHECK_EQUAL("FIRE: not armed", refusal());
  CHECK_EQUAL("the real-time loop stood still while the rig was armed",
              std::string(rig.find(EventKind::disarmed)->detail.view()));
  CHECK(bench.arm() != 0);  // no stop: nobody asked for one
}

TEST(Sequencer, EndsTheLoopWhenTheChipIsGoneThoughNothingIsFired) {
  rig.levels_readable = false;
  rig.set_succeeds = [](Output, bool) { return false; };
  bool goes_on = true;
  for (int turn = 0; goes_on && turn < 3; ++turn) goes_on = bench.step();
  CHECK_FALSE(goes_on);
  CHECK_EQUAL(1u, rig.count(EventKind::fault));
}

TEST(Sequencer, EndsTheLoopWhenTheChipGoesAfterAFaultOfAnotherCause) {
  rig.levels_readable = false;
  while (bench.sequencer.state() != State::fault) CHECK_TRUE(bench.step());
  rig.set_succeeds = [](Output, bool) { return false; };
  bool goes_on = true;
  for (int turn = 0; goes_on && turn < 3; ++turn) goes_on = bench.step();
  CHECK_FALSE(goes_on);
}

TEST(Sequencer, FlashesInTimeThoughWhoeverSleepsIsWokenAMillisecondLate) {
  // A sleeper would be 800 us late; one that is awake 4 ms ahead only sees its own turn, of some 3 us, end.
  rig.wake_delay = milliseconds(1);
  bench.shoot();
  CHECK_TRUE(bench.shot().abort_reason.empty());
  const auto flashes = rig.instants(Output::strobes);
  CHECK_EQUAL(167u, flashes.size());
  for (std::size_t k = 0; k < flashes.size(); ++k) {
    const Duration late = flashes[k] - (flashes[0] + microseconds(3000) * static_cast<std::int64_t>(k));
    CHECK(late < microseconds(1) && late > -microseconds(1));
  }
}

TEST(Sequencer, IsNeverAwakeForMoreThanItsShareOfASecondHoweverCloseTheFlashes) {
  Rig config = shipped_rig();
  config.plan.period = config.lamps.min_period;
  config.lamps.max_flashes = 2000;
  config.plan.exposure = milliseconds(1990);
  SequencerFixture close(config);
  MonoTime until = close.fire() + milliseconds(310 - 250);  // the train's begin
  while (close.rig.time < until) close.sequencer.step(until);
  for (int window = 0; window < 2; ++window) {
    const Duration slept = close.rig.slept;
    until = close.rig.time + milliseconds(1000);
    while (close.rig.time < until) close.sequencer.step(until);
    // The kernel stops whoever is awake for more than 950 of 1000 ms.
    CHECK(close.rig.slept - slept >= milliseconds(70));
  }
  close.play();
  CHECK_TRUE(close.shot().abort_reason.empty());
}

TEST(Sequencer, IsAwakeThroughAWholeShotAsShipped) {
  bench.fire();
  while (rig.instants(Output::shutter).empty()) bench.step();
  const Duration slept = rig.slept;
  while (rig.instants(Output::strobes).size() < 167) bench.step();
  // The shutter's lag is longer than what the loop is awake before the first flash.
  CHECK(rig.slept - slept <= bench.config.shutter.lag);
}

TEST(Sequencer, LatchesAFaultWhileTheInputsCannotBeRead) {
  rig.levels_readable = false;
  for (int turn = 0; turn < 3; ++turn) bench.step();
  CHECK_EQUAL(State::fault, bench.sequencer.state());
  CHECK_EQUAL(1u, rig.count(EventKind::fault));
  bench.give(bench.plain_command(CommandKind::clear));
  CHECK_EQUAL(State::fault, bench.sequencer.state());  // the cause is still there
  rig.levels_readable = true;
  bench.give(bench.plain_command(CommandKind::clear));
  CHECK_EQUAL(State::idle, bench.sequencer.state());
  bench.shoot();
  CHECK(bench.shot().abort_reason.empty());
}
