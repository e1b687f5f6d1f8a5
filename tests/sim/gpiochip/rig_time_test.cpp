#include "sim/gpiochip/rig_time.hpp"

#include <chrono>
#include <memory>
#include <thread>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/system.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::sim::gpio;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kLongestLatency = 70'000;

void pass(std::int64_t duration_ns) { std::this_thread::sleep_for(std::chrono::nanoseconds(duration_ns)); }

}  // namespace

TEST_GROUP(RigTime) {
  std::unique_ptr<State> state = std::make_unique<State>();

  void setup() override {
    state->line_count = 8;
    clear_ring(*state);
  }
  void keep() { keep_time(*state, newest(*state)); }
  /// `body` in a thread that is the loop.
  template <typename Body>
  void as_loop(const Body& body) {
    std::thread([&] {
      become_loop(*state);
      body();
    }).join();
  }
  /// The loop sleeps while its native poll takes this much of the machine's time; how long that was in rig time.
  std::int64_t slept(std::int64_t duration_ns, std::int64_t machine_ns) {
    const std::int64_t begin = now_ns(*state);
    sleep_loop(*state, duration_ns, [&](std::int64_t) {
      pass(machine_ns);
      return 0;
    });
    return now_ns(*state) - begin;
  }
};

TEST(RigTime, IsTheMachinesUntilItIsKept) {
  const std::int64_t before = sys::now_ns();
  const std::int64_t now = now_ns(*state);
  CHECK(before <= now && now <= sys::now_ns());
}

TEST(RigTime, StandsStillAtWhatTheRigDoesNext) {
  keep();
  const std::int64_t due = now_ns(*state) + 2 * kMs;
  rig_turned(*state, newest(*state), due);
  pass(10 * kMs);
  CHECK_EQUAL(due, now_ns(*state));
  CHECK(lag_ns(*state) >= 8 * kMs);
  rig_turned(*state, newest(*state), kNever);
  CHECK(now_ns(*state) >= due + 8 * kMs);
}

TEST(RigTime, WhatTakesTheCoreFromTheLoopCostsAStepAtMost) {
  keep();
  as_loop([this] {
    const std::int64_t begin = now_ns(*state);
    pass(20 * kMs);
    CHECK(now_ns(*state) - begin <= kLongestStep);
  });
}

TEST(RigTime, NobodyIsAheadOfALoopThatRuns) {
  keep();
  as_loop([this] {
    const std::int64_t own = now_ns(*state);
    pass(5 * kMs);
    std::int64_t others = 0;
    std::thread([&] { others = now_ns(*state); }).join();
    CHECK_EQUAL(own, others);
  });
}

TEST(RigTime, TheLoopWakesAtItsInstantHoweverLateTheMachineIs) {
  keep();
  as_loop([this] {
    const std::int64_t took = slept(2 * kMs, 30 * kMs);
    CHECK(took >= 2 * kMs);
    CHECK(took <= 2 * kMs + kLongestLatency + 3 * kLongestStep);
  });
}

TEST(RigTime, ALoopThatFellBehindCatchesUpWakeUpByWakeUp) {
  keep();
  as_loop([this] {
    pass(40 * kMs);
    for (int i = 0; i < 5; ++i) CHECK(slept(2 * kMs, 1) <= 2 * kMs + kLongestLatency + 3 * kLongestStep);
    CHECK(slept(100 * kMs, 10 * kMs) >= 100 * kMs);
  });
}

TEST(RigTime, AnEdgeWaitsForTheSleepingLoop) {
  keep();
  as_loop([this] {
    const std::int64_t begin = now_ns(*state);
    std::int64_t edge = 0;
    const int ready = sleep_loop(*state, 500 * kMs, [&](std::int64_t) {
      std::thread([&] {
        edge = now_ns(*state);
        hold_for_edge(*state, edge);
      }).join();
      pass(20 * kMs);
      return 1;
    });
    CHECK_EQUAL(1, ready);
    CHECK(begin <= edge);
    CHECK(now_ns(*state) - edge <= kLongestLatency + 3 * kLongestStep);
  });
}

TEST(RigTime, TheLoopWaitsUntilTheRigHasSeenWhatItDid) {
  keep();
  std::atomic<bool> seen{false};
  std::thread rig([&] {
    while (newest(*state) == 0) pass(kMs);
    pass(10 * kMs);
    seen = true;
    rig_turned(*state, newest(*state), kNever);
  });
  as_loop([&] {
    change_line(*state, 3, drive_edit(1), CauseCode::set, now_ns(*state));
    now_ns(*state);
    CHECK(seen);
  });
  rig.join();
}

TEST(RigTime, GoesOnWithoutALoopThatIsDead) {
  keep();
  as_loop([this] { now_ns(*state); });
  const std::int64_t stood = now_ns(*state);
  LoopWatch watch;
  while (state->time.loop_ns.load() != kNever) {
    watch.look(*state);
    pass(kMs);
  }
  CHECK(now_ns(*state) > stood);
}

TEST(RigTime, GoesOnWithoutALoopThatBlocksAndTakesItInAgain) {
  keep();
  as_loop([this] {
    const std::int64_t stood = now_ns(*state);
    LoopWatch watch;
    std::thread([&] {
      while (state->time.loop_ns.load() != kNever) {
        watch.look(*state);
        pass(kMs);
      }
    }).join();
    const std::int64_t now = now_ns(*state);
    CHECK(now >= stood + 100 * kMs);  // it looks ten times, each 10 ms
    CHECK_EQUAL(now, state->time.loop_ns.load());
  });
}
