// Gated trains: the ball in the light gate starts the burst. And what the sensors saw of a free one.

#include "tests/support/sequencer_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

namespace {

Rig gated_rig() {
  Rig rig = shipped_rig();
  rig.plan.train = Train::gated;
  rig.plan.flash_count = 12;
  rig.plan.gate_delay = milliseconds(4);
  return rig;
}

}  // namespace

TEST_GROUP(SequencerGate) {
  SequencerFixture bench{gated_rig()};
  VirtualRig& rig = bench.rig;
  void gate(MonoTime when) { rig.schedule({Input::gate, when, true}); }
};

TEST(SequencerGate, WaitsForLampsThatWouldNotHaveRechargedWhenTheShutterOpens) {
  Rig config = gated_rig();
  config.lamps.min_period = config.plan.period = milliseconds(100);
  config.plan.flash_count = 2;
  SequencerFixture slow(config);
  const std::int64_t token = slow.arm();
  slow.give(slow.fire_command(token));  // the shutter would be open 80 ms after the start of the firmware
  CHECK_EQUAL(1u, slow.rig.count(EventKind::refused));
  for (const MonoTime end = slow.rig.time + milliseconds(21); slow.rig.time < end;) slow.step();
  slow.give(slow.fire_command(token));
  CHECK_EQUAL(1u, slow.rig.count(EventKind::refused));
  CHECK_EQUAL(1u, slow.rig.count(EventKind::shot_started));
}

TEST(SequencerGate, StartsTheBurstADelayAfterItsStamp) {
  const MonoTime start = bench.fire();
  const MonoTime stamp = start + milliseconds(200) + nanoseconds(123'457);
  gate(stamp);
  bench.play();
  CHECK(bench.shot().abort_reason.empty());
  CHECK_EQUAL(stamp, bench.shot().gate);
  const auto flashes = rig.instants(Output::strobes);
  CHECK_EQUAL(12u, flashes.size());
  for (std::size_t k = 0; k < flashes.size(); ++k) {
    const MonoTime due = stamp + milliseconds(4) + microseconds(3000) * static_cast<std::int64_t>(k);
    CHECK(flashes[k] - due <= nanoseconds(100));
    CHECK_EQUAL(due, bench.shot().flashes[k].commanded);
    CHECK(known(bench.shot().flashes[k].observed_a));
  }
}

TEST(SequencerGate, IsAbortedWhenTheGateIsNeverSeen) {
  const MonoTime start = bench.shoot();
  CHECK_EQUAL("gate never seen", bench.abort_reason());
  CHECK(rig.find(EventKind::shot_aborted)->device_time - (start + kFirstFlashAt + milliseconds(500)) <
        milliseconds(1));
  CHECK_EQUAL(0u, rig.instants(Output::strobes).size());
  CHECK_TRUE(rig.all_inactive());
}

TEST(SequencerGate, IgnoresAGateBeforeTheTriggerOfASecondShotToo) {
  bench.shoot();
  const MonoTime start = bench.fire();
  gate(start - milliseconds(5));
  bench.play();
  CHECK_FALSE(known(bench.shot(1).gate));
}

TEST(SequencerGate, IgnoresAGateThatWasInterruptedBeforeTheTrigger) {
  const MonoTime start = bench.fire();
  gate(start - milliseconds(5));
  gate(start + milliseconds(200));
  bench.play();
  CHECK_EQUAL(start + milliseconds(200), bench.shot().gate);
  CHECK_EQUAL(12u, rig.instants(Output::strobes).size());
}

TEST(SequencerGate, CountsOnlyTheFirstInterruption) {
  const MonoTime start = bench.fire();
  gate(start + milliseconds(200));
  gate(start + milliseconds(210));
  bench.play();
  CHECK_EQUAL(12u, rig.instants(Output::strobes).size());
  CHECK_EQUAL(2u, rig.count(EventKind::gate));
}

TEST(SequencerGate, IsAbortedWhenTheBallIsTooEarlyForTheShutter) {
  const MonoTime start = bench.fire();
  gate(start + milliseconds(20));  // 24 ms: the shutter is open after 60 ms
  bench.play();
  STRCMP_CONTAINS("before the shutter was open", bench.abort_reason().c_str());
}

TEST(SequencerGate, IsAbortedWhenTheBallIsTooLateForTheExposure) {
  const MonoTime start = bench.fire();
  gate(start + milliseconds(550));
  bench.play();
  STRCMP_CONTAINS("too late", bench.abort_reason().c_str());
  CHECK_TRUE(rig.all_inactive());
}

TEST(SequencerGate, IsAbortedWhenTheEdgeIsReadTooLate) {
  const MonoTime start = bench.fire();
  gate(start + milliseconds(200));
  rig.freeze(start + milliseconds(199), milliseconds(50));
  bench.play();
  STRCMP_CONTAINS("flash 0 would have been", bench.abort_reason().c_str());
  CHECK_EQUAL(0u, rig.instants(Output::strobes).size());
}

TEST(SequencerGate, TakesAHandForTheBallInADryShot) {
  const MonoTime start = bench.fire(true);
  gate(start + milliseconds(200));
  bench.play();
  CHECK_EQUAL(12u, rig.instants(Output::strobes).size());
  CHECK_EQUAL(0u, rig.instants(Output::trigger).size());
}

TEST_GROUP(SequencerSensors) {
  SequencerFixture bench;
  VirtualRig& rig = bench.rig;
};

TEST(SequencerSensors, ShowAMissingFlash) {
  rig.missing_flashes = {40, 41};
  bench.shoot();
  for (std::size_t k = 0; k < bench.shot().flashes.size(); ++k) {
    CHECK_EQUAL(k != 40 && k != 41, known(bench.shot().flashes[k].observed_a));
    CHECK(known(bench.shot().flashes[k].issue_end));
  }
}

TEST(SequencerSensors, ShowADoubleFlash) {
  const MonoTime start = bench.fire();
  rig.schedule({Input::sensor_b, start + kFirstFlashAt + microseconds(3000) * 7 + microseconds(900), true});
  bench.play();
  CHECK_EQUAL(1, bench.shot().flashes[7].extra_edges);
  CHECK_EQUAL(0, bench.shot().flashes[6].extra_edges + bench.shot().flashes[8].extra_edges);
}

TEST(SequencerSensors, DoWithOneOfThem) {
  rig.sensor_a_works = false;
  bench.shoot();
  for (const FlashRecord& flash : bench.shot().flashes) {
    CHECK_FALSE(known(flash.observed_a));
    CHECK(known(flash.observed_b));
  }
}

TEST(SequencerSensors, AreNotReportedOutsideAShot) {
  rig.schedule({Input::sensor_a, rig.time + milliseconds(5), true});
  for (int turn = 0; turn < 3; ++turn) bench.step();
  CHECK_EQUAL(0u, rig.count(EventKind::sensor));
}
