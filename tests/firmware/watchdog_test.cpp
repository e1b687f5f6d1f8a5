#include "firmware/linux/watchdog.hpp"

#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;
using Verdict = Watchdog::Verdict;

namespace {

constexpr MonoTime kNow = from_ns(100'000'000'000);
constexpr Duration kCheckInterval = milliseconds(100);

/// A core, in milliseconds: it runs and stands still by turns.
class Core {
 public:
  void stand_still(int from_ms, int for_ms) { stills_.emplace_back(from_ms, from_ms + for_ms); }
  /// When something that is due then gets its turn.
  int turn_ms(int due_ms) const {
    for (const auto& [from, until] : stills_)
      if (due_ms >= from && due_ms < until) due_ms = until;
    return due_ms;
  }

 private:
  std::vector<std::pair<int, int>> stills_;  ///< one after the other
};

/// A loop on one core, which turns every 50 ms until it hangs, and a guardian that may have another core
/// until it goes to the loop's. When it is said that the loop hangs or stands still; -1: never.
struct Machine {
  Core loops, others;
  Core loop_alone;  ///< a page from a disk, or a bus, that the loop waits for while its core runs
  bool shot_under_way = true;
  int hangs_from_ms = INT32_MAX;
  int slow_ms = 0;  ///< the loop's turn after its core runs again

  int said_ms(int until_ms) const {
    Watchdog judge;
    bool beside = false;
    int loop_due_ms = 50, loop_ms = 0;
    for (int now_ms = 0; now_ms < until_ms;) {
      while (loop_due_ms < hangs_from_ms) {
        const int turn_ms = loops.turn_ms(loop_alone.turn_ms(loop_due_ms));
        const int late_ms = turn_ms > loop_due_ms ? slow_ms : 0;
        if (turn_ms + late_ms >= std::min(now_ms, hangs_from_ms)) break;
        loop_ms = turn_ms + late_ms;
        loop_due_ms = loop_ms + 50;
      }
      const MonoTime now = kNow + milliseconds(now_ms);
      const Verdict verdict = judge.check({kNow + milliseconds(loop_ms), now, shot_under_way}, now, beside);
      if (verdict == (shot_under_way ? Verdict::loop_hung : Verdict::loop_stands_still)) return now_ms;
      if (verdict != Verdict::healthy) throw std::logic_error("another verdict");
      beside = judge.suspect();
      const int due_ms = now_ms + static_cast<int>(judge.until_next_check() / milliseconds(1));
      now_ms = (beside ? loops : others).turn_ms(due_ms);
    }
    return -1;
  }
};

constexpr int kStandstillsEnd_ms = 6500, kLongest_ms = 1500;

/// Between two standstills the loop gets its turn.
Core any_core() {
  Core core;
  for (int at_ms = *rc::gen::inRange(0, 300); at_ms < kStandstillsEnd_ms - kLongest_ms;) {
    const int for_ms = *rc::gen::inRange(1, kLongest_ms);
    core.stand_still(at_ms, for_ms);
    at_ms += for_ms + *rc::gen::inRange(150, 600);
  }
  return core;
}

}  // namespace

TEST_GROUP(Watchdog) {
  Watchdog judge;

  /// From `from` on, every 10 ms, with the other thread well; the first verdict that is not `well`, and when.
  Verdict look_on(Heartbeats marks, MonoTime from, Duration for_long, MonoTime* when = nullptr) {
    for (MonoTime now = from; now <= from + for_long; now = now + milliseconds(10)) {
      const Verdict verdict = judge.check(marks, now);
      if (when != nullptr) *when = now;
      if (verdict != Verdict::healthy) return verdict;
    }
    return Verdict::healthy;
  }
};

TEST(Watchdog, FindsNothingInThreadsThatTurnOrHaveNotBegun) {
  for (int look = 0; look < 3; ++look) {
    CHECK_EQUAL(Verdict::healthy, judge.check({}, kNow, true));
    CHECK_EQUAL(Verdict::healthy,
                judge.check({kNow - milliseconds(60), kNow - milliseconds(600)}, kNow, true));
  }
}

TEST(Watchdog, SaysByTimeAloneThatTheLoopHangs) {
  MonoTime when{};
  CHECK_EQUAL(Verdict::loop_hung, look_on({kNow, kNow}, kNow, milliseconds(2'000), &when));
  CHECK(when - kNow > Watchdog::kLoopTimeout && when - kNow <= milliseconds(500 + 100 + 10));
}

TEST(Watchdog, GivesTheLoopItsTurnAfterTheWholeMachineStoodStill) {
  const MonoTime stood = kNow - milliseconds(3'000);
  judge.check({stood, kNow}, stood);
  CHECK_EQUAL(Verdict::healthy, look_on({stood, kNow}, kNow, milliseconds(40)));
  CHECK_EQUAL(Verdict::healthy, judge.check({kNow + milliseconds(50), kNow}, kNow + milliseconds(50)));
}

TEST(Watchdog, LooksCloselyOnceTheLoopHasMissedATurn) {
  judge.check({kNow, kNow}, kNow + milliseconds(40));
  CHECK_FALSE(judge.suspect());
  CHECK_EQUAL(milliseconds(61), judge.until_next_check());
  judge.check({kNow, kNow}, kNow + milliseconds(101));
  CHECK(judge.suspect());
  CHECK_EQUAL(milliseconds(10), judge.until_next_check());
}

TEST(Watchdog, SaysThatALoopHangsWhoseCoreRuns) {
  // 101 ms until it is suspect, then 60 ms in looks of 10.
  Machine machine;
  machine.hangs_from_ms = 1000;
  const int said_ms = machine.said_ms(3000);
  CHECK(said_ms > 1000 && said_ms <= 1000 + 101 + 60);
}

TEST(Watchdog, DoesNotTakeACoreThatStandsStillForAHang) {
  Machine machine;
  machine.loops.stand_still(1010, 1200);
  LONGS_EQUAL(-1, machine.said_ms(4000));
}

TEST(Watchdog, CountsNoTimeThatItDidNotSeePass) {
  Machine machine;
  machine.hangs_from_ms = 1000;
  for (int at_ms = 1100; at_ms < 1500; at_ms += 40) machine.loops.stand_still(at_ms, 20);
  const int said_ms = machine.said_ms(4000);
  CHECK(said_ms > 1500 && said_ms < 1000 + 500 + 2 * 100);
}

TEST(Watchdog, TakesNoStandstillForAHangAndLeavesNoHangForLong) {
  CHECK(rc::check("standstills of both cores", [] {
    Machine machine;
    machine.loops = any_core();
    machine.others = any_core();
    machine.slow_ms = *rc::gen::inRange(0, 50);
    RC_ASSERT(machine.said_ms(8000) == -1);
    machine.hangs_from_ms = *rc::gen::inRange(100, 5000);
    const int said_ms = machine.said_ms(20000);
    RC_ASSERT(said_ms > machine.hangs_from_ms);
    RC_ASSERT(said_ms <= kStandstillsEnd_ms + 500 + 200);  // by time alone at the latest
  }));
}

TEST(Watchdog, TakesALoopThatWaitsInTheKernelForAHangWhileAShotIsUnderWayOnly) {
  Machine machine;
  machine.loop_alone.stand_still(1010, 400);
  const int said_ms = machine.said_ms(4000);
  CHECK(said_ms > 1010 && said_ms <= 1010 + 101 + 60);
  machine.shot_under_way = false;
  LONGS_EQUAL(said_ms, machine.said_ms(4000));
}

TEST(Watchdog, WaitsForALoopThatStandsStillWithoutAShotUntilItTurnsAgain) {
  const Heartbeats still{kNow, kNow, false};
  CHECK_EQUAL(Verdict::loop_stands_still, look_on(still, kNow, milliseconds(2'000)));
  CHECK_EQUAL(Verdict::loop_stands_still, judge.check(still, kNow + milliseconds(9'000)));
  const MonoTime later = kNow + milliseconds(9'050);
  CHECK_EQUAL(Verdict::healthy, judge.check({later, later, false}, later));
  CHECK_EQUAL(Verdict::loop_hung, look_on({later, later, true}, later, milliseconds(2'000)));
}

TEST(Watchdog, HasPatienceWithAPublisherOnASlowDisk) {
  for (Duration passed{}; passed <= milliseconds(10'000); passed = passed + kCheckInterval)
    CHECK_EQUAL(Verdict::healthy, judge.check({kNow + passed, kNow}, kNow + passed));
  const MonoTime later = kNow + milliseconds(10'010);
  CHECK_EQUAL(Verdict::publisher_hung, look_on({later, kNow}, later, milliseconds(150)));
}

TEST(Watchdog, TakesTheLoopMoreSeriously) {
  const MonoTime stood = kNow - milliseconds(20'000);
  CHECK_EQUAL(Verdict::loop_hung, look_on({stood, stood}, kNow, kCheckInterval * 2));
}

TEST(Watchdog, IsDoneWithThePublisherBeforeTheServiceManagerLosesPatience) {
  CHECK_EQUAL(Watchdog::kPublisherTimeout, Watchdog::publisher_timeout_for(milliseconds(0)));
  CHECK_EQUAL(Watchdog::publisher_timeout_for(milliseconds(4'000)), milliseconds(2'000));
  CHECK_EQUAL(Watchdog::kPublisherTimeout, Watchdog::publisher_timeout_for(milliseconds(60'000)));
}
