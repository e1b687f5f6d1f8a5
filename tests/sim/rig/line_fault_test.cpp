// Faults of single lines and of the shutter: what the rig's lines and its film then show.

#include "sim/rig/exposure.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

TEST_GROUP(LineFault) { Scene scene = test::plain_scene(); };

TEST(LineFault, ADimFlashIsSeenByItsSensorAndNotOnTheFilm) {
  test::VirtualRigFixture sound(scene);
  const auto all = film_images(scene, sound.shoot());
  scene.faults = {{.kind = FaultKind::flash_dim, .flash_from_impact = -1}};
  test::VirtualRigFixture fixture(scene);
  const Exposure exposure = fixture.shoot();
  LONGS_EQUAL(all.size() - 1, film_images(scene, exposure).size());
  LONGS_EQUAL(sound.drives_of(RigLine::sensor_a, 1).size(), fixture.drives_of(RigLine::sensor_a, 1).size());
  CHECK(exposure.has(FaultKind::flash_dim));
}

TEST(LineFault, ASensorThatDropsOutLeavesTheFilmAsItIs) {
  test::VirtualRigFixture sound(scene);
  const auto all = film_images(scene, sound.shoot());
  scene.faults = {{.kind = FaultKind::sensor_dropout, .flash_index = 5, .lamp_b = false}};
  test::VirtualRigFixture fixture(scene);
  const Exposure exposure = fixture.shoot();
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
  test::VirtualRigFixture fixture(scene);
  const Exposure exposure = fixture.shoot();
  CHECK_FALSE(known(exposure.opened));
  CHECK(film_images(scene, exposure).empty());
  CHECK_FALSE(shows_impact(exposure));
  CHECK(exposure.has(FaultKind::shutter_stuck));
}
