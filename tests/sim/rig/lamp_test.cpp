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
