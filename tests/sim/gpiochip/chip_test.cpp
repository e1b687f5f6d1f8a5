#include <signal.h>
#include <unistd.h>

#include <fstream>

#include "sim/gpiochip/chip.hpp"
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

TEST_GROUP(SimulatedChip) {
  testing::TemporaryFolder folder;

  std::string refusal(const ChipSpec& spec) {
    const auto chip = Chip::create(folder / "chip", spec);
    return chip ? "" : chip.error().message;
  }
};

TEST(SimulatedChip, FindsItsLinesByName) {
  ChipFixture fixture;
  LONGS_EQUAL(16, fixture.chip().line_count());
  LONGS_EQUAL(3, fixture.chip().line_named("TRIGGER").value());
  CHECK_FALSE(fixture.chip().line_named("NOWHERE").has_value());
  CHECK_EQUAL("SPARE_15", fixture.chip().line_name(15));
}

TEST(SimulatedChip, StartsWithTheBoardsLevels) {
  ChipFixture fixture;
  LONGS_EQUAL(0, fixture.chip().state(0).level);
  LONGS_EQUAL(1, fixture.chip().state(8).level);
  CHECK_FALSE(fixture.chip().state(8).is_output);
  CHECK_FALSE(fixture.chip().state(8).requested);
}

TEST(SimulatedChip, IsSeenByAnotherProcessThatAttaches) {
  ChipFixture fixture;
  auto other = Chip::attach(fixture.chip_folder());
  CHECK_TRUE(other.has_value());
  other->drive(4, 1, now());
  LONGS_EQUAL(1, fixture.chip().state(4).level);
}

TEST(SimulatedChip, ReportsADriveWithItsVeryStamp) {
  ChipFixture fixture;
  const MonoTime stamp = now() - microseconds(7);
  fixture.chip().drive(4, 1, stamp);
  const std::vector<Change> changes = fixture.changes(1);
  CHECK_EQUAL(stamp, changes[0].time);
  LONGS_EQUAL(4, changes[0].line);
  LONGS_EQUAL(1, changes[0].level);
  CHECK_EQUAL(Cause::drive, changes[0].cause);
}

TEST(SimulatedChip, ReturnsAtTheDeadlineWhenNothingHappens) {
  ChipFixture fixture;
  ChangeCursor cursor = fixture.chip().cursor_now();
  std::vector<Change> changes;
  const MonoTime deadline = now() + milliseconds(5);
  CHECK_TRUE(fixture.chip().wait_changes(cursor, deadline, changes));
  CHECK_TRUE(now() >= deadline);
  CHECK_TRUE(changes.empty());
}

TEST(SimulatedChip, TellsALappedReaderAndLetsItGoOn) {
  ChipFixture fixture;
  ChangeCursor cursor = fixture.chip().cursor_now();
  constexpr int kDrives = 70'000;  // more than the 65536 that are kept
  for (int i = 0; i < kDrives; ++i) fixture.chip().drive(4, (i + 1) % 2, now());
  std::vector<Change> changes;
  CHECK_FALSE(fixture.chip().wait_changes(cursor, now(), changes));
  CHECK_TRUE(fixture.chip().wait_changes(cursor, now(), changes));
  LONGS_EQUAL(65'536, changes.size());
  LONGS_EQUAL(0, changes.back().level);
}

TEST(SimulatedChip, HasAFolderToItself) {
  ChipFixture fixture;
  const auto second = Chip::create(fixture.chip_folder(), standard_chip());
  CHECK_FALSE(second.has_value());
  STRCMP_CONTAINS("already", second.error().message.c_str());
}

TEST(SimulatedChip, RemovesWhatItMade) {
  ChipFixture fixture;
  CHECK_TRUE(std::filesystem::exists(fixture.chip_folder()));
  fixture.remove_chip();
  CHECK_FALSE(std::filesystem::exists(fixture.chip_folder()));
}

TEST(SimulatedChip, TakesThePlaceOfOneWhoseCreatorWasKilled) {
  testing::Command command{{built_program("gpiochip_host").string(), (folder / "chip").string()}, {}, {}, {}};
  testing::Process host(command, folder.path());
  CHECK_TRUE(host.wait_for_out("STROBE_GPIOCHIP_DIR", kLimit));
  CHECK_TRUE(refusal(standard_chip()).find("already") != std::string::npos);
  host.signal(SIGKILL);
  host.wait(kLimit);
  CHECK_EQUAL("", refusal(standard_chip()));
}

TEST(SimulatedChip, CannotBeAttachedToWhereThereIsNone) {
  const auto chip = Chip::attach(folder.path());
  CHECK_FALSE(chip.has_value());
  STRCMP_CONTAINS(folder.path().c_str(), chip.error().message.c_str());
}

TEST(SimulatedChip, RefusesAStateFileThatIsNotOne) {
  std::ofstream(folder / "state") << "something else";
  CHECK_FALSE(Chip::attach(folder.path()).has_value());
}

TEST(SimulatedChip, RefusesSpecificationsThatNoChipCanHave) {
  ChipSpec spec = standard_chip();
  spec.lines.resize(65);
  STRCMP_CONTAINS("64", refusal(spec).c_str());
  spec.lines.clear();
  STRCMP_CONTAINS("64", refusal(spec).c_str());
  spec = standard_chip();
  spec.name = "../null";
  STRCMP_CONTAINS("../null", refusal(spec).c_str());
  spec = standard_chip();
  spec.lines[0].name = std::string(32, 'x');
  STRCMP_CONTAINS("too long", refusal(spec).c_str());
  spec = standard_chip();
  spec.lines[1].idle_level = 2;
  STRCMP_CONTAINS("STROBE_B", refusal(spec).c_str());
}

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
