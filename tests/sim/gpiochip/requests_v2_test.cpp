// Line requests of uAPI v2: who owns lines, what becomes of them, and the events of their edges.
#include <linux/gpio.h>
#include <signal.h>

#include <sstream>
#include <thread>

#include "tests/sim/gpiochip/fixture.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

namespace {

constexpr const char* kActor = "gpio_actor_v2";
const std::string kDefaultBuffer = "0";

struct Event {
  std::uint32_t id = 0, line = 0, number = 0, number_of_line = 0;
  std::int64_t stamp_ns = 0;
  bool operator==(const Event&) const = default;
};

constexpr std::uint32_t kRising = GPIO_V2_LINE_EVENT_RISING_EDGE;
constexpr std::uint32_t kFalling = GPIO_V2_LINE_EVENT_FALLING_EDGE;

std::vector<Event> events_in(const std::string& text) {
  std::istringstream lines(text.substr(text.find('\n') + 1));  // after "ready"
  std::vector<Event> found;
  Event event;
  while (lines >> event.id >> event.line >> event.number >> event.number_of_line >> event.stamp_ns)
    found.push_back(event);
  return found;
}

/// Toggles a line that often, the last time at least to 0.
void toggle(Chip& chip, std::uint32_t line, int count) {
  for (int i = 0; i < count; ++i) chip.drive(line, (i + 1) % 2, now());
}

}  // namespace

TEST_GROUP(LineRequests) {
  ChipFixture fixture;

  testing::Process actor(std::vector<std::string> role, const std::string& until = "ready") {
    return fixture.actor(std::move(role), until, kActor);
  }
};

TEST_GROUP(RequestEvents) {
  ChipFixture fixture;

  testing::Process reader(const std::string& role, const std::string& lines,
                          const std::string& buffer = kDefaultBuffer) {
    return fixture.actor({role, lines, buffer}, "ready", kActor);
  }

  std::vector<Event> wait_for(testing::Process & process, std::size_t count) {
    testing::wait_until([&] { return events_in(process.out()).size() >= count; }, kLimit);
    return events_in(process.out());
  }

  /// What the late reader finds in its queue.
  std::vector<Event> queued(testing::Process & late) {
    late.signal(SIGUSR1);
    CHECK_TRUE(late.wait_for_out("end", kLimit));
    return events_in(late.out());
  }
};

TEST(LineRequests, AreSeenByTheRig) {
  const auto holder = actor({"hold", "0,1", "1"});
  const LineState state = fixture.chip().state(0);
  CHECK_TRUE(state.requested);
  CHECK_TRUE(state.is_output);
  LONGS_EQUAL(1, state.level);
  LONGS_EQUAL(0, fixture.chip().state(1).level);
  CHECK_EQUAL("actor", state.consumer);
}

TEST(LineRequests, SetTheirLinesAtOneInstant) {
  actor({"toggle", "0,2,3", "2"}, "done");
  const std::vector<Change> changes = fixture.changes(6);
  LONGS_EQUAL(6, changes.size());
  CHECK_EQUAL(changes[0].time, changes[2].time);
  CHECK_EQUAL(changes[3].time, changes[5].time);
  const std::vector<int> pulse{1, 0};
  CHECK_EQUAL(pulse, ChipFixture::levels(changes, 2));
}

TEST(LineRequests, EndWithTheirProcess) {
  auto holder = actor({"hold", "0,1", "3"});
  holder.signal(SIGKILL);
  holder.wait(kLimit);
  CHECK_FALSE(fixture.chip().state(0).requested);
  LONGS_EQUAL(1, fixture.chip().state(1).level);  // as a Raspberry Pi's
  CHECK_EQUAL("", fixture.chip().state(1).consumer);
}

TEST(LineRequests, LetGoOfTheirLinesOnAChipThatMakesThemInputs) {
  ChipSpec spec = standard_chip();
  spec.on_release = OnRelease::input;
  ChipFixture other(spec);
  auto holder = other.actor({"hold", "0,1", "3"}, "ready", kActor);
  other.changes(2);
  holder.signal(SIGKILL);
  const std::vector<Change> changes = other.changes(2);
  LONGS_EQUAL(2, changes.size());
  CHECK_EQUAL(Cause::release, changes[0].cause);
  LONGS_EQUAL(0, other.chip().state(1).level);
}

TEST(LineRequests, TurnAnOutputIntoAnInputWhileTheyHoldIt) {
  auto holder = actor({"turn", "4"});
  LONGS_EQUAL(1, fixture.chip().state(4).level);
  holder.signal(SIGUSR1);
  CHECK_TRUE(holder.wait_for_out("input", kLimit));
  const std::vector<int> up_and_let_go{1, 0};
  CHECK_EQUAL(up_and_let_go, ChipFixture::levels(fixture.changes(2), 4));
  fixture.chip().drive(4, 1, now());
  LONGS_EQUAL(1, fixture.chip().state(4).level);
  CHECK_TRUE(fixture.chip().state(4).requested);
}

TEST(LineRequests, CanBeAsManyAsThereAreLines) {
  std::string all = "0";
  for (int line = 1; line < 16; ++line) all += "," + std::to_string(line);
  actor({"slots", all, "3"}, "done");
  actor({"slots", all, "3"}, "done");
}

TEST(LineRequests, ShareTheLinesWithHandlesOfVersion1) {
  std::vector<testing::Process> holders;
  for (unsigned line = 0; line < 16; line += 2) {
    holders.push_back(actor({"hold", std::to_string(line), "1"}));
    holders.push_back(fixture.actor({"hold", std::to_string(line + 1), "1"}));
  }
  for (std::uint32_t line = 0; line < 16; ++line) LONGS_EQUAL(1, fixture.chip().state(line).level);
  const auto late = fixture.run({built_program(kActor).string(), "hold", "1", "0"});
  CHECK_EQUAL("request: EBUSY\n", late.out);
}

// As tried by hand on a real kernel. A program that then lets go of such a request does not come back from
// Linux 6.1, so that the conformance program leaves it out.
TEST(LineRequests, EndWhenTheDeviceIsUnplugged) {
  auto holder = actor({"unplugged", "4"});
  fixture.chip().drive(5, 1, now());  // its event is queued, and gone with the device
  fixture.chip().unplug();
  holder.signal(SIGUSR1);
  LONGS_EQUAL(0, holder.wait(kLimit).value().code);
  CHECK_EQUAL(
      "ready\nset ENODEV\nget ENODEV\nconfigure ENODEV\npoll hang-up\nread ENODEV\npoll hang-up\n"
      "read ENODEV\ninfo ENODEV\n",
      holder.out());
}

TEST(LineRequests, KilledInTheMiddleLeaveAUsableChip) {
  for (int i = 0; i < 60; ++i) {
    testing::Process victim(fixture.preloaded({built_program(kActor).string(), "toggle", "0,1,2,3", "0"}),
                            fixture.logs());
    if (i % 2 == 0) CHECK_TRUE(victim.wait_for_out("ready", kLimit));  // else maybe inside its request
    testing::wait_until([] { return false; }, std::chrono::milliseconds(i % 5));
    victim.signal(SIGKILL);
    victim.wait(kLimit);
  }
  for (std::uint32_t line = 0; line < 4; ++line) CHECK_FALSE(fixture.chip().state(line).requested);
  actor({"toggle", "0,1,2,3", "2"}, "done");
}

TEST(RequestEvents, AreNumberedForTheRequestAndForEachLine) {
  auto process = reader("events", "4,5");
  const MonoTime first = now();
  fixture.chip().drive(4, 1, first);
  fixture.chip().drive(5, 1, first + nanoseconds(1));
  fixture.chip().drive(4, 0, first + nanoseconds(2));
  const std::int64_t stamp_ns = to_ns(first);
  const std::vector<Event> expected = {
      {kRising, 4, 1, 1, stamp_ns}, {kRising, 5, 2, 1, stamp_ns + 1}, {kFalling, 4, 3, 2, stamp_ns + 2}};
  CHECK_EQUAL(expected, wait_for(process, 3));
}

TEST(RequestEvents, OfADebouncedLineComeOnceItHasSettled) {
  auto process = reader("bouncing", "4", "10000");
  const MonoTime first = now() - milliseconds(100);
  const auto drive_at = [&](int level, int after_ms) {
    fixture.chip().drive(4, level, first + milliseconds(after_ms));
  };
  drive_at(1, 0);
  drive_at(0, 1);
  drive_at(1, 2);  // settles 10 ms later
  drive_at(0, 30);
  drive_at(1, 31);  // settles where it was
  drive_at(0, 50);
  const std::vector<Event> expected = {{kRising, 4, 1, 1, to_ns(first + milliseconds(12))},
                                       {kFalling, 4, 2, 2, to_ns(first + milliseconds(60))}};
  ChangeCursor cursor = fixture.chip().cursor_now();
  std::vector<Change> changes;
  fixture.chip().wait_changes(cursor, now() + milliseconds(2), changes);  // the last one is due
  CHECK_EQUAL(expected, wait_for(process, 2));
}

TEST(RequestEvents, AreQueuedSixteenALineAndTheOldestAreLost) {
  auto one = reader("late", "4"), two = reader("late", "5,6");
  toggle(fixture.chip(), 4, 20);
  toggle(fixture.chip(), 5, 30);
  toggle(fixture.chip(), 6, 10);
  const std::vector<Event> of_one = queued(one), of_two = queued(two);
  LONGS_EQUAL(16, of_one.size());
  LONGS_EQUAL(5, of_one.front().number);  // four were lost
  LONGS_EQUAL(20, of_one.back().number);
  LONGS_EQUAL(32, of_two.size());
  LONGS_EQUAL(9, of_two.front().number);
  LONGS_EQUAL(9, of_two.front().number_of_line);
  LONGS_EQUAL(40, of_two.back().number);
  LONGS_EQUAL(10, of_two.back().number_of_line);
}

TEST(RequestEvents, AreQueuedAThousandDeepWhereThatIsAskedFor) {
  auto process = reader("late", "4", "100000");
  toggle(fixture.chip(), 4, 1'100);
  const std::vector<Event> found = queued(process);
  LONGS_EQUAL(1'024, found.size());
  LONGS_EQUAL(77, found.front().number);
}

TEST(RequestEvents, StayQueuedWhenOneOfSeveralRigsLetsGoOfTheChip) {
  auto process = reader("late", "4");
  {
    const Chip other = std::move(*Chip::attach(fixture.chip_folder()));
    toggle(fixture.chip(), 4, 3);
  }
  LONGS_EQUAL(3, queued(process).size());
}

TEST(RequestEvents, OfAnEarlierOwnerAreNotHandedToTheNext) {
  {
    auto first = reader("late", "4");
    toggle(fixture.chip(), 4, 3);
  }
  CHECK_FALSE(fixture.chip().state(4).requested);  // so that its queue is free for the next
  auto second = reader("events", "4");
  const MonoTime stamp = now();
  fixture.chip().drive(4, 0, stamp);
  const std::vector<Event> expected = {{kFalling, 4, 1, 1, to_ns(stamp)}};
  CHECK_EQUAL(expected, wait_for(second, 1));
}

TEST(RequestEvents, OfLinesDrivenByTwoProcessesAreQueuedInTheirNumbersOrder) {
  constexpr int kEdges = 2'000;
  auto process = reader("events", "4,5", "1024");
  Chip other = std::move(*Chip::attach(fixture.chip_folder()));
  std::thread second([&] { toggle(other, 5, kEdges); });
  toggle(fixture.chip(), 4, kEdges);
  second.join();
  CHECK_TRUE(testing::wait_until(
      [&] {
        const auto found = events_in(process.out());
        return !found.empty() && found.back().number == 2 * kEdges;
      },
      kLimit));
  std::uint32_t number = 0;
  std::array<std::uint32_t, 2> of_line{};
  for (const Event& event : events_in(process.out())) {
    CHECK_TRUE(event.number > number);
    CHECK_TRUE(event.number_of_line > of_line[event.line - 4]);
    number = event.number;
    of_line[event.line - 4] = event.number_of_line;
  }
  LONGS_EQUAL(kEdges, std::max(of_line[0], of_line[1]));
}

TEST(RequestEvents, ThatOverflowWhileTheyAreReadAreWholeAndInOrder) {
  constexpr int kEdges = 20'000;
  auto process = reader("events", "4", "2");
  toggle(fixture.chip(), 4, kEdges);
  CHECK_TRUE(testing::wait_until(
      [&] {
        const auto found = events_in(process.out());
        return !found.empty() && found.back().number == kEdges;
      },
      kLimit));
  std::uint32_t number = 0;
  for (const Event& event : events_in(process.out())) {
    CHECK_TRUE(event.number > number);
    LONGS_EQUAL(event.number % 2 == 1 ? kRising : kFalling, event.id);
    LONGS_EQUAL(event.number, event.number_of_line);
    number = event.number;
  }
}

// Watched lines: who watches is told what others do with a line.

TEST_GROUP(LineWatches) {
  ChipFixture fixture;

  testing::Process actor(std::vector<std::string> role, const std::string& until = "ready") {
    return fixture.actor(std::move(role), until, "gpio_actor_v2");
  }

  /// As a rig does all the time.
  bool said_while_the_rig_looks(testing::Process & watcher, const std::string& text) {
    return testing::wait_until(
        [&] {
          ChangeCursor cursor = fixture.chip().cursor_now();
          std::vector<Change> changes;
          fixture.chip().wait_changes(cursor, now() + milliseconds(2), changes);
          return watcher.out().find(text) != std::string::npos;
        },
        kLimit);
  }
};

TEST(LineWatches, TellOfRequestsConfigurationsAndReleasesOfOthers) {
  auto watcher = actor({"watch", "4,5"});
  {
    auto holder = actor({"turn", "4"});
    holder.signal(SIGUSR1);
    CHECK_TRUE(holder.wait_for_out("input", kLimit));
    auto unseen = actor({"hold", "6", "0"});
    holder.signal(SIGKILL);
    holder.wait(kLimit);
  }
  CHECK_TRUE(said_while_the_rig_looks(watcher, "2 4"));
  auto first_version = fixture.actor({"hold", "5", "1"});
  CHECK_TRUE(said_while_the_rig_looks(watcher, "1 5"));
  CHECK_EQUAL("ready\n1 4 actor\n3 4 actor\n2 4 \n1 5 actor\n", watcher.out());
}

TEST(LineWatches, OfManyProgramsAreAllServed) {
  auto first = actor({"watch", "4"}), second = actor({"watch", "3,4"});
  auto holder = actor({"hold", "4", "0"});
  CHECK_TRUE(first.wait_for_out("1 4 actor\n", kLimit));
  CHECK_TRUE(second.wait_for_out("1 4 actor\n", kLimit));
}

TEST(LineWatches, CanBeMadeByAsManyOpensOfTheChipAsItHas) {
  {
    auto greedy = actor({"opens", "40"});
    STRCMP_CONTAINS("watching 32\n", greedy.out().c_str());
  }
  auto next = actor({"opens", "32"});  // those of a dead process are free again
  STRCMP_CONTAINS("watching 32\n", next.out().c_str());
}
