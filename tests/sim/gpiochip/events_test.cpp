#include <linux/gpio.h>
#include <signal.h>

#include <sstream>

#include "tests/sim/gpiochip/fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

namespace {

struct Event {
  int id = 0;
  std::int64_t stamp_ns = 0;
  bool operator==(const Event&) const = default;
};

std::vector<Event> events_in(const std::string& text) {
  std::istringstream lines(text.substr(text.find('\n') + 1));  // after "ready"
  std::vector<Event> found;
  Event event;
  while (lines >> event.id >> event.stamp_ns) found.push_back(event);
  return found;
}

constexpr int kRising = GPIOEVENT_EVENT_RISING_EDGE;
constexpr int kFalling = GPIOEVENT_EVENT_FALLING_EDGE;
const std::string kBothEdges = "3";
const std::string kRisingEdge = "1";
const std::string kNoFlags = "0";

}  // namespace

TEST_GROUP(EdgeEvents) {
  ChipFixture fixture;

  /// Drives the line with stamps 1 µs apart that end now, and returns them.
  std::vector<std::int64_t> drive(std::uint32_t line, const std::vector<int>& levels) {
    std::vector<std::int64_t> stamps;
    MonoTime stamp = now() - microseconds(static_cast<std::int64_t>(levels.size()));
    for (const int level : levels) {
      fixture.chip().drive(line, level, stamp);
      stamps.push_back(to_ns(stamp));
      stamp = stamp + microseconds(1);
    }
    return stamps;
  }

  std::vector<Event> wait_for(testing::Process & reader, std::size_t count) {
    testing::wait_until([&] { return events_in(reader.out()).size() >= count; }, kLimit);
    return events_in(reader.out());
  }
};

TEST_GROUP(UnpluggedChip){};

TEST(EdgeEvents, CarryTheStampsThatWereGiven) {
  auto reader = fixture.actor({"events", "4", kBothEdges, kNoFlags});
  const auto stamps = drive(4, {1, 0, 1});
  const std::vector<Event> expected = {{kRising, stamps[0]}, {kFalling, stamps[1]}, {kRising, stamps[2]}};
  CHECK_EQUAL(expected, wait_for(reader, 3));
}

TEST(EdgeEvents, ComeOnlyForTheEdgesAskedFor) {
  auto reader = fixture.actor({"events", "4", kRisingEdge, kNoFlags});
  const auto stamps = drive(4, {1, 0, 1});
  const std::vector<Event> expected = {{kRising, stamps[0]}, {kRising, stamps[2]}};
  CHECK_EQUAL(expected, wait_for(reader, 2));
}

TEST(EdgeEvents, OfAnActiveLowLineRiseWhenTheLevelFalls) {
  auto reader = fixture.actor({"events", "8", kRisingEdge, std::to_string(GPIOHANDLE_REQUEST_ACTIVE_LOW)});
  const auto stamps = drive(8, {0, 1, 0});
  const std::vector<Event> expected = {{kRising, stamps[0]}, {kRising, stamps[2]}};
  CHECK_EQUAL(expected, wait_for(reader, 2));
}

TEST(EdgeEvents, DoNotComeForALevelThatStays) {
  auto reader = fixture.actor({"events", "4", kBothEdges, kNoFlags});
  const auto stamps = drive(4, {0, 1, 1, 0});
  const std::vector<Event> expected = {{kRising, stamps[1]}, {kFalling, stamps[3]}};
  CHECK_EQUAL(expected, wait_for(reader, 2));
}

TEST(EdgeEvents, AreQueuedSixteenDeepAndTheNewestAreLost) {
  auto reader = fixture.actor({"late", "4"});
  std::vector<int> levels;
  for (int i = 0; i < 20; ++i) levels.push_back((i + 1) % 2);
  const auto stamps = drive(4, levels);
  reader.signal(SIGUSR1);
  CHECK_TRUE(reader.wait_for_out("end", kLimit));
  const std::vector<Event> found = events_in(reader.out());
  LONGS_EQUAL(16, found.size());
  for (std::size_t i = 0; i < 16; ++i) CHECK_EQUAL(stamps[i], found[i].stamp_ns);
}

TEST(EdgeEvents, StayQueuedWhenOneOfSeveralRigsLetsGoOfTheChip) {
  auto reader = fixture.actor({"late", "4"});
  {
    const Chip other = std::move(*Chip::attach(fixture.chip_folder()));
    drive(4, {1, 0, 1});
  }
  reader.signal(SIGUSR1);
  CHECK_TRUE(reader.wait_for_out("end", kLimit));
  LONGS_EQUAL(3, events_in(reader.out()).size());
}

TEST(EdgeEvents, OfAnEarlierOwnerAreNotHandedToTheNext) {
  {
    auto first = fixture.actor({"late", "4"});
    drive(4, {1, 0, 1});
  }
  auto second = fixture.actor({"events", "4", kBothEdges, kNoFlags});
  const auto stamps = drive(4, {0});
  const std::vector<Event> expected = {{kFalling, stamps[0]}};
  CHECK_EQUAL(expected, wait_for(second, 1));
}

TEST(EdgeEvents, EndWhenTheDeviceIsUnplugged) {
  auto actor = fixture.actor({"unplugged", "4"});
  fixture.chip().unplug();
  actor.signal(SIGUSR1);
  LONGS_EQUAL(0, actor.wait(kLimit).value().code);
  CHECK_EQUAL("ready\nset ENODEV\nget ENODEV\npoll 1 hang-up\nread ENODEV\nopen ENOENT\n", actor.out());
}

TEST(EdgeEvents, EndForAReaderWhoWaitsWhenAnotherProcessUnplugsTheDevice) {
  auto reader = fixture.actor({"events", "4", kBothEdges, kNoFlags});
  drive(4, {1});
  wait_for(reader, 1);
  Chip::attach(fixture.chip_folder())->unplug();
  CHECK_TRUE(testing::wait_until(
      [&] {
        ChangeCursor cursor = fixture.chip().cursor_now();
        std::vector<Change> changes;
        fixture.chip().wait_changes(cursor, now(), changes);
        return !reader.running();
      },
      kLimit));
}

TEST(UnpluggedChip, GoesOnDrivingWhatItDroveWhereItKeepsReleasedOutputs) {
  ChipFixture fixture;
  auto holder = fixture.actor({"hold", "0,4", "1,1"});
  fixture.chip().unplug();
  LONGS_EQUAL(1, fixture.chip().state(0).level);
  CHECK_TRUE(fixture.chip().unplugged());
}

TEST(UnpluggedChip, LetsGoOfAllItsLinesWhereItDoesNot) {
  ChipSpec spec = standard_chip();
  spec.on_release = OnRelease::input;
  ChipFixture fixture(spec);
  auto holder = fixture.actor({"hold", "0,4", "1,1"});
  fixture.changes(2);
  fixture.chip().unplug();
  LONGS_EQUAL(0, fixture.chip().state(0).level);
  const std::vector<Change> changes = fixture.changes(2);
  LONGS_EQUAL(2, changes.size());
  CHECK_EQUAL(Cause::release, changes[0].cause);
}
