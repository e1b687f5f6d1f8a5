#include <algorithm>
#include <map>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <vector>

#include "firmware/publisher/journal.hpp"
#include "tests/soak/bus.hpp"
#include "tests/soak/disk.hpp"
#include "tests/soak/lab.hpp"
#include "tests/soak/lab_setup.hpp"
#include "tests/support/journal_entries.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::soak;

namespace {

std::vector<firmware::Message> event(std::int64_t sequence) {
  strobe_msgs::event_t message{};
  message.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  message.boot_id = 5;
  message.sequence = sequence;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return {{firmware::Message::Kind::event, {sequence, sequence}, "STROBE/bench/EVENT", bytes}};
}

}  // namespace

TEST_GROUP(VirtualBus) {
  VirtualBus bus{7};

  /// Sends packets 0, 1, 2 ... one a millisecond; gives their numbers in order of arrival.
  std::vector<int> arrivals(int count, Receiver to = Receiver::host) {
    for (int i = 0; i < count; ++i) {
      const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i)};
      bus.send(to, "channel", bytes, from_ns(std::int64_t{i} * 1'000'000));
    }
    std::vector<int> numbers;
    MonoTime last{};
    while (bus.next_due() != kFarFuture) {
      const auto delivery = bus.take();
      CHECK(delivery.at >= last);
      last = delivery.at;
      numbers.push_back(delivery.packet->bytes[0] << 8 | delivery.packet->bytes[1]);
      CHECK(delivery.at > from_ns(std::int64_t{numbers.back()} * 1'000'000));
      bus.done(delivery);
    }
    return numbers;
  }
};

TEST(VirtualBus, DeliversEachPacketOnceAndInOrderWithoutFaults) {
  const auto numbers = arrivals(3000);
  LONGS_EQUAL(3000, numbers.size());
  for (int i = 0; i < 3000; ++i) LONGS_EQUAL(i, numbers[static_cast<std::size_t>(i)]);
}

TEST(VirtualBus, KeepsItsOrderEvenIfPacketsAreSentAtOneInstant) {
  for (std::uint8_t i = 0; i < 200; ++i) bus.send(Receiver::host, "c", std::vector{i}, from_ns(5));
  for (std::uint8_t i = 0; i < 200; ++i) {
    const auto delivery = bus.take();
    LONGS_EQUAL(i, delivery.packet->bytes[0]);
    bus.done(delivery);
  }
}

TEST(VirtualBus, LosesTheStatedShareOfPackets) {
  bus.set_faults({.loss = 0.2});
  const auto numbers = arrivals(20'000);
  // 4000 lost with a sd of 57.
  CHECK(std::abs(static_cast<double>(bus.counts().lost) - 4000.0) < 5.0 * 57.0);
  LONGS_EQUAL(20'000 - bus.counts().lost, static_cast<std::int64_t>(numbers.size()));
}

TEST(VirtualBus, DoublesPackets) {
  bus.set_faults({.duplication = 0.1});
  std::map<int, int> times;
  for (const int number : arrivals(10'000)) ++times[number];
  std::int64_t doubled = 0;
  for (const auto& [number, count] : times) doubled += count == 2 ? 1 : 0;
  LONGS_EQUAL(10'000, times.size());
  LONGS_EQUAL(bus.counts().doubled, doubled);
  CHECK(doubled > 800 && doubled < 1200);  // sd 30
}

TEST(VirtualBus, LetsPacketsOvertakeEachOther) {
  bus.set_faults({.reordering = 0.1});
  const auto numbers = arrivals(5'000);
  LONGS_EQUAL(5'000, numbers.size());
  int overtaken = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) overtaken += numbers[i] < numbers[i - 1] ? 1 : 0;
  CHECK(overtaken > 300);
}

TEST(VirtualBus, RepeatsItselfFromItsSeed) {
  const BusFaults faults{0.2, 0.1, 0.1};
  bus.set_faults(faults);
  const auto first = arrivals(2'000);
  bus = VirtualBus(7);
  bus.set_faults(faults);
  CHECK_EQUAL(arrivals(2'000), first);
  bus = VirtualBus(8);
  bus.set_faults(faults);
  CHECK(first != arrivals(2'000));
}

TEST_GROUP(VirtualDisk){};

TEST(VirtualDisk, CutsAWriteShortWhereItIsFullAndTakesItWhenThereIsRoomAgain) {
  VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), 5);
  CHECK_TRUE(journal.has_value());
  CHECK_TRUE(journal->append(event(1), 0).has_value());
  for (const std::uint64_t room : {0, 10, 100}) {  // less than an event takes
    disk.fill(room);
    CHECK_TRUE(disk.full());
    bool done = true;
    disk.write([&] { done = journal->append(event(2), 0).has_value(); });
    CHECK_FALSE(done);
    LONGS_EQUAL(1, testing::journal_entries(journal->path()).size());
  }
  disk.make_room();
  disk.write([&] { CHECK_TRUE(journal->append(event(2), 0).has_value()); });
  LONGS_EQUAL(2, testing::journal_entries(journal->path()).size());
}

TEST(VirtualDisk, KeepsWhatWasWrittenAfterItsWriterHasEnded) {
  VirtualDisk disk;
  {
    auto journal = firmware::Journal::create(disk.path(), 5);
    CHECK_TRUE(journal->append(event(1), 0).has_value());
  }
  LONGS_EQUAL(1, testing::journal_entries(firmware::journal_path(disk.path(), 5)).size());
}

TEST(VirtualDisk, LeavesNothingBehind) {
  std::filesystem::path path;
  {
    const VirtualDisk disk;
    path = disk.path();
    CHECK_TRUE(std::filesystem::is_directory(path));
  }
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_GROUP(Timeline){};

TEST(Timeline, GivesWhatHappensInOrderOfTimeAndAtOneInstantAsItWasScheduled) {
  Timeline<int> timeline;
  CHECK_EQUAL(kFarFuture, timeline.next());
  timeline.schedule(from_ns(20), 3);
  timeline.schedule(from_ns(10), 1);
  timeline.schedule(from_ns(20), 4);
  timeline.schedule(from_ns(10), 2);
  for (int expected = 1; expected <= 4; ++expected) {
    CHECK_EQUAL(from_ns(expected <= 2 ? 10 : 20), timeline.next());
    LONGS_EQUAL(expected, timeline.take().item);
  }
  CHECK_TRUE(timeline.empty());
}

TEST_GROUP(FaultPlan){};

TEST(FaultPlan, ReadsProbabilitiesByTheirNames) {
  const auto plan = read_fault_plan("flash_late = 0.5\nestop = 0.25\npacket_loss = 0.125\n", "faults.toml");
  CHECK_TRUE(plan.has_value());
  DOUBLES_EQUAL(0.5, plan->rig[static_cast<std::size_t>(sim::FaultKind::flash_late)], 0.0);
  DOUBLES_EQUAL(0.25, (*plan)[Hazard::estop], 0.0);
  DOUBLES_EQUAL(0.125, plan->packet_loss, 0.0);
  DOUBLES_EQUAL(0.0, (*plan)[Hazard::key_off], 0.0);
}

TEST(FaultPlan, NamesFileLineAndKeyOfWhatIsWrong) {
  const auto unknown = read_fault_plan("estop = 0.1\nflash_latte = 0.5\n", "faults.toml");
  CHECK_FALSE(unknown.has_value());
  STRCMP_CONTAINS("faults.toml:2: flash_latte", unknown.error().message.c_str());
  const auto large = read_fault_plan("estop = 1.5\n", "faults.toml");
  CHECK_FALSE(large.has_value());
  STRCMP_CONTAINS("faults.toml:1: estop", large.error().message.c_str());
  CHECK_FALSE(find_fault_plan("tame").has_value());
  CHECK((*find_fault_plan("stops"))[Hazard::page_disarm] > 0.0);
}

TEST(FaultPlan, StrikesWithTheStatedProbability) {
  FaultPlan plan;
  plan[sim::FaultKind::flash_dim] = 0.25;
  Random random(3);
  const auto faults = draw_rig_faults(plan, 4000, random);
  for (const auto& fault : faults) CHECK_EQUAL(sim::FaultKind::flash_dim, fault.kind);
  CHECK(faults.size() > 850 && faults.size() < 1150);  // 1000 with a sd of 27
  CHECK_TRUE(draw_rig_faults(no_faults(), 4000, random).empty());
}

// Whole shots in the virtual lab: some thousand of them in each test run. The long run is tests/soak/run.

TEST_GROUP(VirtualLab) {
  RigFiles files = *read_rig_files(STROBE_SHIPPED_RIG);
  std::string violations;

  SoakCounts run_lab(const FaultPlan& faults, PlanKind plan, int runs, int shots = 10,
                     std::uint64_t seed = 2026) {
    SoakCounts sum;
    for (int run = 0; run < runs; ++run) {
      RunSettings settings;
      settings.seed = seed;
      settings.run = run;
      settings.shots = shots;
      settings.faults = faults;
      settings.plan = plan;
      Lab lab(files, settings);
      sum.add(lab.run());
      for (const std::string& violation : lab.invariant_checker().violations())
        violations += "\nseed " + std::to_string(seed) + ", run " + std::to_string(run) + ": " + violation;
    }
    CHECK_EQUAL("", violations);
    return sum;
  }
  template <std::size_t N>
  bool all_occurred(const std::array<std::int64_t, N>& counts) const {
    return std::ranges::all_of(counts, [](std::int64_t count) { return count > 0; });
  }
};

TEST(VirtualLab, ReadsEveryShotOutWhenNothingGoesWrong) {
  const SoakCounts counts = run_lab(no_faults(), PlanKind::brief, 60);
  LONGS_EQUAL(600, counts.good);
  LONGS_EQUAL(counts.shots, counts.triggers);
  LONGS_EQUAL(0, counts.unfinished);
  // Two chance errors of a hundred thousand are beyond 4.3 sd.
  for (const double z : counts.largest_z) CHECK(z > 1.0 && z < 6.0);
}

TEST(VirtualLab, PlaysTheShippedPlanAndBurstsAfterTheGate) {
  LONGS_EQUAL(60, run_lab(no_faults(), PlanKind::shipped, 6).good);
  LONGS_EQUAL(100, run_lab(no_faults(), PlanKind::gated, 10).good);
  LONGS_EQUAL(100, run_lab(no_faults(), PlanKind::coded, 10).good);
}

TEST(VirtualLab, HoldsWhatMustHoldThroughEveryKindOfFault) {
  const SoakCounts counts = run_lab(wild_faults(), PlanKind::brief, 60);
  CHECK_TRUE(all_occurred(counts.rig_faults));
  CHECK_TRUE(all_occurred(counts.hazards));
  CHECK(counts.packets_lost > 0 && counts.packets_doubled > 0 && counts.packets_reordered > 0);
  CHECK(counts.events_journalled > 10'000);
  LONGS_EQUAL(0, counts.events_missing);
}

// On a network that delays and doubles, but loses nothing; what a lost DISARM and a firmware that starts anew can do
// is for the long run (`--faults stops`).
TEST(VirtualLab, FiresNothingBetweenAStopAndTheNextActOfAPerson) {
  FaultPlan plan = stop_faults();
  plan.packet_loss = plan[Hazard::network_outage] = 0.0;
  plan[Hazard::firmware_kill] = plan[Hazard::firmware_stop] = 0.0;
  const SoakCounts counts = run_lab(plan, PlanKind::brief, 20);
  CHECK(counts.stops_reached > 200);  // compilers' last digits lead to some 420 or 300
  CHECK(counts.acts > counts.stops_reached / 2);
  CHECK(counts.triggers > 100);
  CHECK(counts.stops_asked > 80);
  CHECK(counts.stops_confirmed > counts.stops_asked / 2);
  LONGS_EQUAL(0, counts.stopped_triggers);
}

TEST(VirtualLab, IsTheSameToTheLastBitWhateverStrangersSend) {
  FaultPlan plan;
  const SoakCounts alone = run_lab(plan, PlanKind::brief, 20);
  plan.strangers = 1.0;
  const SoakCounts attacked = run_lab(plan, PlanKind::brief, 20);
  CHECK(attacked.strangers > 10'000);
  CHECK_EQUAL(alone.digest, attacked.digest);
  LONGS_EQUAL(200, attacked.triggers);
}

TEST(VirtualLab, ThrowsTheBallsAskedForWhileALogOfAnotherDayIsPlayedBack) {
  FaultPlan plan;
  plan.played_back = 0.5;
  const SoakCounts counts = run_lab(plan, PlanKind::brief, 20);
  CHECK(counts.strangers > 5'000);
  LONGS_EQUAL(200, counts.good);
  LONGS_EQUAL(200, counts.triggers);
}

TEST(VirtualLab, IsRightOrSaysThatItIsNotAtTheExtremes) {
  const SoakCounts counts = run_lab(no_faults(), PlanKind::extremes, 40);
  CHECK(counts.compared > 1'000);
}

TEST(VirtualLab, RepeatsItselfToTheLastBitFromItsSeed) {
  const std::uint64_t digest = run_lab(wild_faults(), PlanKind::mixed, 4, 5).digest;
  CHECK_EQUAL(run_lab(wild_faults(), PlanKind::mixed, 4, 5).digest, digest);
  CHECK(digest != run_lab(wild_faults(), PlanKind::mixed, 4, 5, 2027).digest);
}
