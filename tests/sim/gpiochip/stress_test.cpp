#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/sim/gpiochip/fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;

namespace {

std::uint64_t chosen_seed() {
  const char* given = std::getenv("STROBE_TEST_SEED");
  const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
  std::printf("(repeat with STROBE_TEST_SEED=%llu) ", static_cast<unsigned long long>(seed));
  return seed;
}

/// Reads until the actor ended and nothing came any more. Checks that each line's levels alternate.
struct Reader {
  Chip& chip;
  ChangeCursor cursor{};
  bool lapped = false, in_order = true;
  std::vector<std::size_t> count = std::vector<std::size_t>(16, 0);
  std::vector<int> level = std::vector<int>(16, 0);

  /// True if something came, or was lost.
  bool read(Duration patience) {
    std::vector<Change> changes;
    const bool lost = !chip.wait_changes(cursor, now() + patience, changes);
    lapped |= lost;
    for (const Change& change : changes) {
      in_order &= lapped || change.level != level[change.line];
      level[change.line] = change.level;
      ++count[change.line];
    }
    return lost || !changes.empty();
  }
};

}  // namespace

TEST_GROUP(ChipUnderStress) {
  ChipFixture fixture;
  Reader reader{fixture.chip()};
};

TEST(ChipUnderStress, LosesNoChangeOfTwoProcesses) {
  // all four lines' fit into the ring, should this reader be held up
  constexpr std::size_t kChanges = 20'000;
  auto first = fixture.actor({"toggle", "0,1", std::to_string(kChanges / 2), "0"}, "");
  auto second = fixture.actor({"toggle", "2,3", std::to_string(kChanges / 2), "0"}, "");
  while (first.running() || second.running()) reader.read(milliseconds(1));
  while (reader.read(milliseconds(1))) {
  }
  CHECK_FALSE(reader.lapped);
  CHECK_TRUE(reader.in_order);
  for (std::size_t line = 0; line < 4; ++line) LONGS_EQUAL(kChanges / 2, reader.count[line]);
}

TEST(ChipUnderStress, TellsAReaderThatIsTooSlow) {
  auto fast = fixture.actor({"toggle", "0,1", "100000", "0"}, "");
  LONGS_EQUAL(0, fast.wait(kLimit).value().code);
  while (reader.read(milliseconds(1)) || !reader.lapped) {
  }
  CHECK_TRUE(reader.lapped);
  CHECK_TRUE(reader.count[0] + reader.count[1] <= 65'536);
}

TEST(ChipUnderStress, StaysUsableWhenItsUsersAreKilledInTheMiddle) {
  std::mt19937_64 random(chosen_seed());
  std::uniform_int_distribution<int> life_us(0, 3'000);
  constexpr int kKills = 100;
  for (int i = 0; i < kKills; ++i) {
    testing::Process victim(
        fixture.preloaded({built_program("gpio_actor").string(), "toggle", "0,1,2,3", "0", "0"}),
        fixture.logs());
    if (i % 2 == 0) CHECK_TRUE(victim.wait_for_out("ready", kLimit));  // else maybe inside its request
    const MonoTime death = now() + microseconds(life_us(random));
    while (now() < death) reader.read(microseconds(100));
    victim.signal(SIGKILL);
    victim.wait(kLimit);
    reader.lapped = false;  // a loaded machine may hold this reader up; levels are taken anew then
  }
  while (reader.read(milliseconds(5))) {
  }
  for (std::uint32_t line = 0; line < 4; ++line) {
    const LineState state = fixture.chip().state(line);
    CHECK_FALSE(state.requested);
    LONGS_EQUAL(state.level, reader.level[line]);  // the last change of every line was reported
  }
  const auto next = fixture.actor({"hold", "0,1,2,3", "1,1,1,1"});
}

TEST(ChipUnderStress, IsNotTakenTwiceAtOnce) {
  constexpr int kRivals = 8;
  std::vector<testing::Process> rivals;
  for (int i = 0; i < kRivals; ++i) {
    rivals.emplace_back(fixture.preloaded({built_program("gpio_actor").string(), "hold", "5,6", "1,1"}),
                        fixture.logs());
  }
  int winners = 0;
  for (testing::Process& rival : rivals) {
    CHECK_TRUE(rival.wait_for_out("\n", kLimit));
    winners += rival.out().find("ready") != std::string::npos ? 1 : 0;
  }
  LONGS_EQUAL(1, winners);
}
