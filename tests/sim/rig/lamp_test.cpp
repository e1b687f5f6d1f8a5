#include <numbers>

#include "sim/rig/exposure.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

TEST_GROUP(LampModel) {
  Scene scene = test::plain_scene();
  std::vector<FaultKind> occurred;

  FlashTimes pulse(LampModel & lamp, MonoTime at, int index = 0, std::optional<int> from_impact = {}) {
    return lamp.on_pulse(at, {.shot = 1, .index = index, .from_impact = from_impact}, occurred);
  }
};

TEST(LampModel, FlashesADelayAfterTheEdge) {
  LampModel lamp(scene, 1, Lamp::a);
  const auto flashes = pulse(lamp, from_ns(1000000));
  LONGS_EQUAL(1, flashes.size());
  CHECK_EQUAL(from_ns(1012000), flashes[0]);
}

TEST(LampModel, DoesNotFlashBeforeItHasRecharged) {
  LampModel lamp(scene, 1, Lamp::a);
  LONGS_EQUAL(1, pulse(lamp, MonoTime{}).size());
  LONGS_EQUAL(0, pulse(lamp, from_ns(1399000), 1).size());
  LONGS_EQUAL(1, pulse(lamp, from_ns(1400000), 2).size());
}

TEST(LampModel, CountsRechargingFromTheFlashAndNotFromAPulseThatMadeNone) {
  LampModel lamp(scene, 1, Lamp::a);
  pulse(lamp, MonoTime{});
  pulse(lamp, from_ns(1000000), 1);
  LONGS_EQUAL(1, pulse(lamp, from_ns(1500000), 2).size());
}

TEST(LampModel, RechargesFromTheSecondOfTwoFlashes) {
  scene.faults = {{.kind = FaultKind::flash_double, .flash_index = 0, .delay = milliseconds(1)}};
  LampModel lamp(scene, 1, Lamp::a);
  LONGS_EQUAL(2, pulse(lamp, MonoTime{}, 0).size());
  LONGS_EQUAL(0, pulse(lamp, from_ns(2'399'000), 1).size());
  LONGS_EQUAL(1, pulse(lamp, from_ns(2'400'000), 2).size());
}

TEST(LampModel, NeverFlashesBeforeItsPulseHoweverLargeTheJitter) {
  scene.lamps.jitter_s = 1e-3;
  scene.lamps.recharge_s = 0.0;
  LampModel lamp(scene, 1, Lamp::a);
  for (int i = 0; i < 100; ++i) {
    const MonoTime edge = MonoTime{} + i * milliseconds(100);
    CHECK(pulse(lamp, edge, i)[0] >= edge);
  }
}

TEST(LampModel, FlashesLateByTheFaultsDelayOnlyWhereTheFaultStrikes) {
  scene.faults = {
      {.kind = FaultKind::flash_late, .shot = 1, .flash_from_impact = -2, .delay = microseconds(160)}};
  LampModel lamp(scene, 1, Lamp::a);
  CHECK_EQUAL(from_ns(12000), pulse(lamp, MonoTime{}, 0, -3)[0]);
  CHECK(occurred.empty());
  CHECK_EQUAL(from_ns(3172000), pulse(lamp, from_ns(3000000), 1, -2)[0]);
  CHECK_EQUAL(std::vector{FaultKind::flash_late}, occurred);
}

TEST(LampModel, LeavesTheOtherLampAloneWhenTheFaultNamesOne) {
  scene.faults = {{.kind = FaultKind::flash_missing, .flash_index = 4, .lamp_a = false}};
  LampModel a(scene, 1, Lamp::a);
  LampModel b(scene, 1, Lamp::b);
  LONGS_EQUAL(1, pulse(a, MonoTime{}, 4).size());
  LONGS_EQUAL(0, pulse(b, MonoTime{}, 4).size());
}

TEST(LampModel, FlashesTwiceForOnePulse) {
  scene.faults = {{.kind = FaultKind::flash_double, .flash_index = 0, .delay = microseconds(300)}};
  LampModel lamp(scene, 1, Lamp::a);
  const auto flashes = pulse(lamp, MonoTime{});
  LONGS_EQUAL(2, flashes.size());
  CHECK_EQUAL(microseconds(300), flashes[1] - flashes[0]);
}

TEST(LampModel, NeverFlashesWhenDead) {
  scene.faults = {{.kind = FaultKind::lamp_dead, .shot = 1}};
  LampModel lamp(scene, 1, Lamp::a);
  for (int i = 0; i < 10; ++i) CHECK(pulse(lamp, from_ns(3000000LL * i), i).empty());
}

TEST(LampModel, KeepsTheJitterOfOtherFlashesWhenOneIsMissing) {
  scene.lamps.jitter_s = 1e-6;
  LampModel sound(scene, 9, Lamp::a);
  Scene faulty_scene = scene;
  faulty_scene.faults = {{.kind = FaultKind::flash_missing, .flash_index = 1}};
  LampModel faulty(faulty_scene, 9, Lamp::a);
  for (int i = 0; i < 4; ++i) {
    const auto expected = pulse(sound, from_ns(3000000LL * i), i);
    const auto flashes = pulse(faulty, from_ns(3000000LL * i), i);
    if (i != 1) CHECK_EQUAL(expected, flashes);
  }
}

// Faults of single lines and of the shutter: what the rig's lines and its film then show.

TEST_GROUP(LineFault) { Scene scene = test::plain_scene(); };

TEST(LineFault, ADimFlashIsSeenByItsSensorAndNotOnTheFilm) {
  test::VirtualRigFixture sound(scene);
  const auto all = film_images(scene, sound.shoot());
  scene.faults = {{.kind = FaultKind::flash_dim, .flash_from_impact = -1}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(all.size() - 1, film_images(scene, exposure).size());
  LONGS_EQUAL(sound.drives_of(RigLine::sensor_a, 1).size(), fixture.drives_of(RigLine::sensor_a, 1).size());
  CHECK(exposure.has(FaultKind::flash_dim));
}

TEST(LineFault, ASensorThatDropsOutLeavesTheFilmAsItIs) {
  test::VirtualRigFixture sound(scene);
  const auto all = film_images(scene, sound.shoot());
  scene.faults = {{.kind = FaultKind::sensor_dropout, .flash_index = 5, .lamp_b = false}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(all.size(), film_images(scene, exposure).size());
  LONGS_EQUAL(sound.drives_of(RigLine::sensor_a, 1).size() - 1,
              fixture.drives_of(RigLine::sensor_a, 1).size());
  LONGS_EQUAL(sound.drives_of(RigLine::sensor_b, 1).size(), fixture.drives_of(RigLine::sensor_b, 1).size());
  CHECK(exposure.has(FaultKind::sensor_dropout));
}

TEST(LineFault, ABouncingSensorRisesTwiceForOneFlash) {
  for (const Duration delay : {microseconds(30), microseconds(400)}) {  // within its pulse and after it
    scene.faults = {{.kind = FaultKind::sensor_bounce, .flash_index = 5, .lamp_b = false, .delay = delay}};
    test::VirtualRigFixture fixture(scene);
    fixture.shoot();
    const auto rises = fixture.drives_of(RigLine::sensor_a, 1);
    LONGS_EQUAL(fixture.drives_of(RigLine::sensor_b, 1).size() + 1, rises.size());
    CHECK_EQUAL(delay, rises[6].at - rises[5].at);
    LONGS_EQUAL(rises.size(), fixture.drives_of(RigLine::sensor_a, 0).size());
  }
}

TEST(LineFault, AChatteringGateIsInterruptedBeforeTheBallComes) {
  test::VirtualRigFixture sound(scene);
  sound.shoot();
  scene.faults = {{.kind = FaultKind::gate_chatter, .delay = microseconds(700)}};
  test::VirtualRigFixture fixture(scene);
  CHECK(fixture.shoot().has(FaultKind::gate_chatter));
  const auto rises = fixture.drives_of(RigLine::gate, 1);
  LONGS_EQUAL(4, rises.size());
  CHECK_EQUAL(sound.drives_of(RigLine::gate, 1)[0].at, rises.back().at);
  CHECK_EQUAL(microseconds(700), rises[3].at - rises[2].at);
}

TEST(LineFault, AStuckShutterShowsNothing) {
  scene.faults = {{.kind = FaultKind::shutter_stuck}};
  auto [fixture, exposure] = test::shot_of(scene);
  CHECK_FALSE(known(exposure.opened));
  CHECK(film_images(scene, exposure).empty());
  CHECK_FALSE(shows_impact(exposure));
  CHECK(exposure.has(FaultKind::shutter_stuck));
}

// What a rig that is wired or set up wrongly does: sensors that see the other lamp, a shutter that is not the line's, a
// machine that throws twice; and balls dropped by hand.

TEST_GROUP(CommissioningFaults) {
  Scene scene = test::plain_scene();

  /// Rises of a line in one shot.
  std::size_t rises(RigLine line) const {
    test::VirtualRigFixture fixture(scene);
    fixture.shoot();
    return fixture.drives_of(line, 1).size();
  }
};

TEST(CommissioningFaults, ASensorWithCrosstalkRisesForTheOtherLamp) {
  scene.faults = {{.kind = FaultKind::lamp_dead, .lamp_a = false}};
  const std::size_t of_lamp_a = rises(RigLine::sensor_a);
  LONGS_EQUAL(0, rises(RigLine::sensor_b));
  scene.sensors.b_sees_a = true;
  LONGS_EQUAL(of_lamp_a, rises(RigLine::sensor_b));
  scene.sensors.b_sees_a = false;
  scene.sensors.a_sees_b = true;  // which does not flash
  LONGS_EQUAL(of_lamp_a, rises(RigLine::sensor_a));
  LONGS_EQUAL(0, rises(RigLine::sensor_b));
}

TEST(CommissioningFaults, LightOfBothLampsInOneSensorIsOneEdge) {
  const std::size_t alone = rises(RigLine::sensor_a);
  scene.sensors.a_sees_b = true;
  LONGS_EQUAL(alone, rises(RigLine::sensor_a));
}

TEST(CommissioningFaults, AShutterThatClosesByItselfCutsTheExposureShort) {
  test::VirtualRigFixture sound(scene);
  const Exposure whole = sound.shoot();
  scene.shutter.longest_open_s = 0.1;
  test::VirtualRigFixture fixture(scene);
  const Exposure cut = fixture.shoot();
  CHECK_EQUAL(milliseconds(100), cut.closed - cut.opened);
  CHECK_EQUAL(cut.closed, fixture.drives_of(RigLine::xsync, 0).back().at);
  LONGS_EQUAL(1, fixture.drives_of(RigLine::xsync, 0).size());
  CHECK(film_images(scene, cut).empty());  // the ball comes after 250 ms
  scene.shutter.longest_open_s = 2.0;
  test::VirtualRigFixture longer(scene);
  CHECK_EQUAL(whole.closed, longer.shoot().closed);
  LONGS_EQUAL(1, longer.drives_of(RigLine::xsync, 0).size());
  CHECK_EQUAL(whole.closed, longer.drives_of(RigLine::xsync, 0).back().at);
}

TEST(CommissioningFaults, ADeadGateSeesNoBall) {
  LONGS_EQUAL(1, rises(RigLine::gate));
  scene.faults = {{.kind = FaultKind::gate_dead}};
  LONGS_EQUAL(0, rises(RigLine::gate));
}

TEST(CommissioningFaults, AMachineThatThrowsTwiceInterruptsTheGateTwice) {
  scene.faults = {{.kind = FaultKind::machine_double, .delay = milliseconds(80)}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(2, exposure.throws);
  LONGS_EQUAL(1, exposure.more_balls.size());
  CHECK(exposure.has(FaultKind::machine_double));
  const auto gate = fixture.drives_of(RigLine::gate, 1);
  LONGS_EQUAL(2, gate.size());
  CHECK_EQUAL(milliseconds(80), gate[1].at - gate[0].at);
  CHECK_EQUAL(milliseconds(80), exposure.more_balls[0].touchdown - exposure.ball->touchdown);
}

TEST(CommissioningFaults, AHandDropsABallWhereTheMachineThrowsNone) {
  scene.hand = {.drop_height_m = 1.0, .touchdown_s = 0.75, .spot_sd_m = 0.0};
  test::VirtualRigFixture fixture(scene);
  const Exposure thrown = fixture.shoot();
  CHECK(thrown.ball->released == MonoTime::min());
  LONGS_EQUAL(1, thrown.throws);
  const test::ShotTimes dry{.period = milliseconds(12), .exposure = milliseconds(1300), .throw_ball = false};
  const Exposure dropped = fixture.shoot(dry);
  LONGS_EQUAL(0, dropped.throws);
  CHECK_EQUAL(milliseconds(750), dropped.ball->touchdown - dropped.opened);
  const auto images = film_images(scene, dropped);
  CHECK(images.size() > 10);
  for (const FilmImage& image : images) CHECK(image.time >= dropped.ball->released);
  // A metre in air of 21 degrees: 4.43 m/s less some 2 %.
  const impact::Motion& touchdown = dropped.ball->path.touchdown();
  DOUBLES_EQUAL(0.0, touchdown.vx_mps, 0.0);
  CHECK(touchdown.vy_mps < -4.3 && touchdown.vy_mps > -4.43);
  const Exposure shorter = fixture.shoot({.period = milliseconds(3), .throw_ball = false});
  CHECK(film_images(scene, shorter).empty());
}

TEST(CommissioningFaults, ABallDroppedOnAnInclinedPlateFallsStraightDown) {
  scene.surface_angle_rad = 0.1;
  scene.hand = {.drop_height_m = 1.0, .touchdown_s = 0.75, .spot_sd_m = 0.0};
  test::VirtualRigFixture fixture(scene);
  const Exposure dropped =
      fixture.shoot({.period = milliseconds(12), .exposure = milliseconds(1300), .throw_ball = false});
  const impact::Motion& touchdown = dropped.ball->path.touchdown();
  DOUBLES_EQUAL(std::tan(0.1), touchdown.vx_mps / touchdown.vy_mps, 1e-9);
}
