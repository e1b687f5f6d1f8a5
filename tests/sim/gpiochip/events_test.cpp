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

constexpr std::uint32_t kKey = 7;
constexpr std::uint32_t kEStop = 8;
const std::string kPullUp = std::to_string(GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_PULL_UP);
const std::string kPullDown = std::to_string(GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_PULL_DOWN);
const std::string kNoBias = std::to_string(GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_DISABLE);
const std::string kAsIs = std::to_string(GPIOHANDLE_REQUEST_INPUT);
const std::string kDown = "0";  // of the actor for uAPI v2
const std::string kUp = "1";

ChipSpec chip_with(Bias bias, int reset_pull) {
  ChipSpec spec = standard_chip();
  spec.bias = bias;
  for (LineSpec& line : spec.lines) line.reset_pull = reset_pull;
  return spec;
}

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

// Resistors of the chip, and wires that break.

TEST_GROUP(OpenWires) {
  ChipFixture fixture;

  static int level(ChipFixture & chip, std::uint32_t line) { return chip.chip().state(line).level; }
  /// By uAPI v1.
  static testing::Process reader(ChipFixture & chip, std::uint32_t line, const std::string& flags) {
    return chip.actor({"events", std::to_string(line), kBothEdges, flags});
  }
  static testing::Process reader_v2(ChipFixture & chip, std::uint32_t line, const std::string& bias) {
    return chip.actor({"pulled", std::to_string(line), bias}, "ready", "gpio_actor_v2");
  }
};

TEST(OpenWires, KeepTheirLevelWhereNothingPulls) {
  fixture.chip().open_wire(kKey, now());
  fixture.chip().open_wire(0, now());
  LONGS_EQUAL(1, level(fixture, kKey));
  LONGS_EQUAL(0, level(fixture, 0));
}

TEST(OpenWires, AreReadByTheResistorThatTheyHadAtReset) {
  ChipFixture pulled(chip_with(Bias::set, 1));
  LONGS_EQUAL(0, level(pulled, 0));  // held from outside
  pulled.chip().open_wire(0, now());
  LONGS_EQUAL(1, level(pulled, 0));
  const auto holder = reader(pulled, 0, kAsIs);
  LONGS_EQUAL(1, level(pulled, 0));
  pulled.chip().drive(0, 0, now());
  LONGS_EQUAL(0, level(pulled, 0));
}

TEST(OpenWires, AreReadByTheBiasOfTheirRequestOfEitherVersion) {
  ChipFixture chip(chip_with(Bias::set, 1));
  for (const std::uint32_t line : {kKey, kEStop, 0U, 1U}) chip.chip().open_wire(line, now());
  const auto key = reader(chip, kKey, kPullDown);
  const auto estop = reader_v2(chip, kEStop, kDown);
  const auto first = reader(chip, 0, kPullUp);
  const auto second = reader_v2(chip, 1, kUp);
  STRCMP_CONTAINS("ready 0", estop.out().c_str());
  STRCMP_CONTAINS("ready 1", second.out().c_str());
  LONGS_EQUAL(0, level(chip, kKey));
  LONGS_EQUAL(0, level(chip, kEStop));
  LONGS_EQUAL(1, level(chip, 0));
}

TEST(OpenWires, DoNotMoveALineThatIsHeldFromOutside) {
  const auto key = reader(fixture, kKey, kPullDown);
  const auto estop = reader_v2(fixture, kEStop, kDown);
  LONGS_EQUAL(1, level(fixture, kKey));
  LONGS_EQUAL(1, level(fixture, kEStop));
}

TEST(OpenWires, KeepABiasThatOutlivesItsRequest) {
  {
    auto holder = reader(fixture, kKey, kPullDown);
    holder.signal(SIGKILL);
    holder.wait(kLimit);
  }
  fixture.chip().open_wire(kKey, now());
  LONGS_EQUAL(0, level(fixture, kKey));
  const auto none = reader(fixture, kKey, kNoBias);
  fixture.chip().drive(kKey, 1, now());
  fixture.chip().open_wire(kKey, now());
  LONGS_EQUAL(1, level(fixture, kKey));
}

TEST(OpenWires, GiveAnEdgeWhenTheyBreakAndWhenTheyAreMended) {
  auto key = reader(fixture, kKey, kPullDown);
  fixture.chip().open_wire(kKey, now());
  fixture.chip().open_wire(kKey, now());  // no edge: it is open already
  fixture.chip().drive(kKey, 0, now());   // nor here
  fixture.chip().drive(kKey, 1, now());
  CHECK(key.wait_for_out("\n1 ", kLimit));
  const std::vector<int> seen = ChipFixture::levels(fixture.changes(2), kKey);
  CHECK_TRUE((std::vector<int>{0, 1}) == seen);
  STRCMP_CONTAINS("ready\n2 ", key.out().c_str());
}

TEST(OpenWires, AreNotPulledByAChipWithoutResistorsThoughItTellsSo) {
  ChipFixture chip(chip_with(Bias::ignored, -1));
  chip.chip().open_wire(kKey, now());
  chip.chip().open_wire(kEStop, now());
  const auto key = reader(chip, kKey, kPullDown);
  const auto estop = reader_v2(chip, kEStop, kDown);
  LONGS_EQUAL(1, level(chip, kKey));
  STRCMP_CONTAINS("ready 1", estop.out().c_str());
}

TEST(OpenWires, OfAChipThatRefusesABiasAreNotTaken) {
  ChipFixture chip(chip_with(Bias::refused, -1));
  for (const char* program : {"gpio_actor", "gpio_actor_v2"}) {
    const bool version2 = std::string(program) == "gpio_actor_v2";
    const std::vector<std::string> role =
        version2 ? std::vector<std::string>{"pulled", "7", kDown}
                 : std::vector<std::string>{"events", "7", kBothEdges, kPullDown};
    const auto refused = chip.actor(role, "EINVAL", program);
    CHECK_FALSE(chip.chip().state(kKey).requested);
    CHECK_EQUAL("", chip.chip().state(kKey).consumer);
  }
  const auto plain = reader(chip, kKey, kAsIs);
  CHECK_TRUE(chip.chip().state(kKey).requested);
}
