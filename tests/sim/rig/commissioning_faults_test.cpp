// What a rig that is wired or set up wrongly does: sensors that see the other lamp, a shutter that is not the line's, a
// machine that throws twice; and balls dropped by hand.

#include <numbers>

#include "sim/rig/exposure.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

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
  test::VirtualRigFixture fixture(scene);
  const Exposure exposure = fixture.shoot();
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
