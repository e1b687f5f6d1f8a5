#include <signal.h>
#include <unistd.h>

#include "tests/sim/gpiochip/fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

namespace {

ChipSpec input_on_release() {
  ChipSpec spec = standard_chip();
  spec.on_release = OnRelease::input;
  return spec;
}

pid_t child_named_in(const std::string& text) {
  return static_cast<pid_t>(std::stol(text.substr(text.find("child ") + 6)));
}

}  // namespace

TEST_GROUP(LineOwnership){};

TEST(LineOwnership, IsSeenByTheRig) {
  ChipFixture fixture;
  const auto holder = fixture.actor({"hold", "0,1", "1,0"});
  const LineState state = fixture.chip().state(0);
  CHECK_TRUE(state.requested);
  CHECK_TRUE(state.is_output);
  LONGS_EQUAL(1, state.level);
  CHECK_EQUAL("actor", state.consumer);
}

TEST(LineOwnership, RecordsTheLevelsOfARequest) {
  ChipFixture fixture;
  const auto holder = fixture.actor({"hold", "0,1,2", "1,0,1"});
  const std::vector<Change> changes = fixture.changes(2);
  LONGS_EQUAL(2, changes.size());
  CHECK_EQUAL(Cause::request, changes[0].cause);
  CHECK_EQUAL(changes[1].time, changes[0].time);
}

TEST(LineOwnership, IsExclusive) {
  ChipFixture fixture;
  const auto holder = fixture.actor({"hold", "2", "1"});
  const auto second = fixture.run({built_program("gpio_actor").string(), "hold", "2", "0"});
  LONGS_EQUAL(1, second.status.value().code);
  CHECK_EQUAL("request: EBUSY\n", second.out);
  LONGS_EQUAL(1, fixture.chip().state(2).level);
}

TEST(LineOwnership, CannotBeHadOfALineThatTheKernelUses) {
  ChipSpec spec = standard_chip();
  spec.lines[2].kernel_used = true;
  ChipFixture fixture(spec);
  CHECK_EQUAL("request: EBUSY\n", fixture.run({built_program("gpio_actor").string(), "hold", "2", "1"}).out);
}

TEST(LineOwnership, EndsWhenItsProcessIsKilledAndTheLevelStays) {
  ChipFixture fixture;
  auto holder = fixture.actor({"hold", "2,3", "1,1"});
  holder.signal(SIGKILL);
  holder.wait(kLimit);
  const LineState state = fixture.chip().state(2);
  CHECK_FALSE(state.requested);
  CHECK_EQUAL("", state.consumer);
  LONGS_EQUAL(1, state.level);
  fixture.changes(2);
  const auto next = fixture.actor({"hold", "2", "0"});
  CHECK_EQUAL(std::vector<int>{0}, fixture.levels(fixture.changes(1), 2));
}

TEST(LineOwnership, EndsWithAnInputOnChipsOfThatKindAndAWaitingRigIsTold) {
  ChipFixture fixture(input_on_release());
  auto holder = fixture.actor({"hold", "2,3", "1,1"});
  fixture.changes(2);
  const MonoTime killed = now();
  holder.signal(SIGKILL);
  const std::vector<Change> changes = fixture.changes(2);
  CHECK_EQUAL(std::vector<int>{0}, fixture.levels(changes, 2));
  CHECK_EQUAL(std::vector<int>{0}, fixture.levels(changes, 3));
  CHECK_EQUAL(Cause::release, changes[0].cause);
  CHECK_TRUE(changes[0].time >= killed);
  CHECK_FALSE(fixture.chip().state(2).is_output);
}

TEST(LineOwnership, IsSharedWithAForkedChildUntilBothAreGone) {
  ChipFixture fixture;
  auto parent = fixture.actor({"orphan", "2"}, "child ");
  LONGS_EQUAL(0, parent.wait(kLimit).value().code);
  CHECK_TRUE(fixture.chip().state(2).requested);
  kill(child_named_in(parent.out()), SIGKILL);
  CHECK_TRUE(testing::wait_until([&] { return !fixture.chip().state(2).requested; }, kLimit));
}

TEST(LineOwnership, IsSharedWithACopyOfTheDescriptor) {
  ChipFixture fixture;
  auto holder = fixture.actor({"copy", "2"});
  CHECK_TRUE(fixture.chip().state(2).requested);
  holder.signal(SIGUSR1);
  CHECK_EQUAL(std::vector<int>{1}, fixture.levels(fixture.changes(1), 2));
  CHECK_TRUE(fixture.chip().state(2).requested);
}

TEST(LineOwnership, WorksForAnOrdinaryUser) {
  if (getuid() != 0) return;  // already one, and so is every other test here
  ChipFixture fixture;
  auto ordinary = fixture.actor({"nobody", "4"});
  CHECK_EQUAL((std::vector<int>{1, 0}), fixture.levels(fixture.changes(2), 4));  // 0 as an input again
  CHECK_TRUE(testing::wait_until([&] { return fixture.chip().state(4).requested; }, kLimit));
  const MonoTime stamp = now();
  fixture.chip().drive(4, 1, stamp);
  ordinary.wait(kLimit);
  STRCMP_CONTAINS(("1 " + std::to_string(to_ns(stamp))).c_str(), ordinary.out().c_str());
}
