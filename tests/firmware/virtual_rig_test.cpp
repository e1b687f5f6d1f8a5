// The tests' own tools: a clock that lies or a hook that counts nothing would make every other test pass.
#include <memory>
#include <string>

#include "tests/support/allocations.hpp"
#include "tests/support/virtual_rig.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

TEST_GROUP(VirtualRig) {
  VirtualRig rig;
  Edge edges[8];
};

TEST(VirtualRig, SleepsUntilTheInstantAndNoLess) {
  const MonoTime until = rig.time + milliseconds(7);
  rig.wait(until, edges);
  CHECK(rig.time >= until);
  CHECK(rig.time < until + microseconds(10));
}

TEST(VirtualRig, WakesAtAnEdgeAndChangesTheLevelWithIt) {
  const MonoTime stamp = rig.time + milliseconds(2);
  rig.schedule({Input::estop, stamp, true});
  CHECK_EQUAL(1u, rig.wait(rig.time + milliseconds(7), edges).value());
  CHECK_EQUAL(stamp, edges[0].time);
  CHECK(rig.estop);
}

TEST(VirtualRig, ShowsALevelBeforeItsEdgeIsRead) {
  rig.schedule({Input::key, rig.time + microseconds(1), false});
  rig.spin_until(rig.time + microseconds(2));
  CHECK_FALSE(rig.level(Input::key).value());
}

TEST(VirtualRig, StandsStillInAFreezeOnce) {
  const MonoTime start = rig.time;
  rig.freeze(start + milliseconds(1), milliseconds(50));
  rig.spin_until(start + milliseconds(2));
  CHECK(rig.time >= start + milliseconds(51));
  CHECK(rig.time < start + milliseconds(52));
  rig.spin_until(start + milliseconds(60));
  CHECK(rig.time < start + milliseconds(61));
}

TEST(VirtualRig, AnswersAFlashWithBothSensors) {
  rig.set(Output::strobes, true);
  const MonoTime flashed = rig.sets.back().time;
  CHECK_EQUAL(2u, rig.wait(rig.time + milliseconds(1), edges).value());
  CHECK_EQUAL(flashed + microseconds(12), edges[0].time);
}

TEST_GROUP(Allocations){};

TEST(Allocations, AreCountedOnThisThread) {
  const AllocationCounter allocations;
  auto one = std::make_unique<int>(1);
  auto text = std::make_unique<std::string>(100, 'x');  // itself and its characters
  CHECK_EQUAL(3, allocations.count());
}
