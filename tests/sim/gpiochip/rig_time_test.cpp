#include <signal.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim/gpiochip/chip.hpp"
#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"
#include "sim/gpiochip/time_keeper.hpp"
#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim::gpio;
using namespace std::chrono_literals;
using strobe::Duration;
using strobe::milliseconds;
using strobe::sim::RigClock;
using strobe::sim::gpio::ThreadStates;
using strobe::testing::wait_until;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kHour = 3'600'000 * kMs;
constexpr std::int64_t kLongestLatency = 70'000;  // of the loop's wake-ups
constexpr TimeKeeper::Repeatable kFromSecond1000{1000, 7};

/// Whatever the machine does meanwhile.
void work(std::int64_t processor_ns) {
  const std::int64_t end = sys::clock_ns(CLOCK_THREAD_CPUTIME_ID) + processor_ns;
  while (sys::clock_ns(CLOCK_THREAD_CPUTIME_ID) < end) continue;
}

pid_t own_thread() { return static_cast<pid_t>(::syscall(SYS_gettid)); }

}  // namespace

/// A keeper, and threads that start together.
TEST_GROUP(RigTime) {
  std::unique_ptr<State> state = std::make_unique<State>();
  std::unique_ptr<TimeKeeper> keeper;
  std::vector<std::thread> threads;
  std::mutex mutex;
  std::vector<std::string> told;

  void setup() override {
    state->line_count = 8;
    clear_ring(*state);
  }
  void teardown() override {
    for (std::thread& thread : threads) thread.join();
    threads.clear();
    keeper.reset();
  }
  /// Time begins once another program takes part: init, which sleeps.
  void keep(Pace pace = Pace::fast) {
    keeper = std::make_unique<TimeKeeper>(*state, pace,
                                          pace == Pace::fast ? std::optional(kFromSecond1000) : std::nullopt);
  }
  void begin() { join_time(*state, ::getppid()); }
  RigClock clock() const { return RigClock(*state); }
  std::int64_t now() const { return now_ns(*state); }
  void sleep(std::int64_t duration_ns) const { clock().sleep_for(Duration{duration_ns}); }
  void tell(const std::string& word) {
    const std::lock_guard lock(mutex);
    told.push_back(word);
  }
  std::string all_told() const {
    std::string all;
    for (const std::string& word : told) all += word + " ";
    return all;
  }
  template <typename Body>
  void in_thread(Body body) {
    std::atomic<bool> runs{false};
    threads.emplace_back([&runs, body] {
      runs = true;
      body();
    });
    while (!runs) std::this_thread::yield();  // its thread id is higher than those before
  }
  template <typename Body>
  void as_loop(Body body) {
    in_thread([this, body] {
      note_real_time(true);
      become_loop(*state);
      body();
    });
  }
  void join() {
    for (std::thread& thread : threads) thread.join();
    threads.clear();
  }
};

TEST(RigTime, IsTheMachinesUntilItIsKept) {
  const std::int64_t before = sys::now_ns();
  const std::int64_t read = now();
  CHECK(before <= read && read <= sys::now_ns());
}

TEST(RigTime, DoesNotBeginBeforeAnotherProgramTakesPart) {
  keep();
  in_thread([this] { sleep(1); });
  std::this_thread::sleep_for(milliseconds(20));
  CHECK_EQUAL(1'000'000 * kMs, now());
  begin();
  join();
  CHECK_EQUAL(1'000'000 * kMs + 1, now());
}

TEST(RigTime, GoesOnAtOnceWhileAllSleep) {
  keep();
  in_thread([this] { sleep(24 * kHour); });
  begin();
  join();
  CHECK_EQUAL(1'000'000 * kMs + 24 * kHour, now());
}

TEST(RigTime, WakesOneAfterTheOtherEachAtItsInstant) {
  keep();
  for (const std::int64_t ms : {30, 10, 20}) {
    in_thread([this, ms] {
      sleep(ms * kMs);
      tell(std::to_string((now() - 1'000'000 * kMs) / kMs));
      CHECK_EQUAL(0, now() % kMs);
    });
  }
  begin();
  join();
  STRCMP_EQUAL("10 20 30 ", all_told().c_str());
}

TEST(RigTime, WakesTheOldestThreadFirstAtOneInstant) {
  keep();
  for (const char* name : {"first", "second", "third"}) {
    in_thread([this, name] {
      for (int i = 0; i < 20; ++i) {
        sleep(kMs);
        tell(name);
      }
    });
  }
  begin();
  join();
  CHECK_EQUAL(60U, told.size());
  for (std::size_t i = 0; i < told.size(); i += 3) {
    STRCMP_EQUAL("first", told[i].c_str());
    STRCMP_EQUAL("second", told[i + 1].c_str());
    STRCMP_EQUAL("third", told[i + 2].c_str());
  }
}

TEST(RigTime, StandsStillWhileSomebodyWorks) {
  keep();
  std::int64_t took = -1;
  in_thread([this] { sleep(50 * kMs); });
  in_thread([this, &took] {
    sleep(kMs);
    const std::int64_t begun = now();
    work(20 * kMs);
    took = now() - begun;
  });
  begin();
  join();
  CHECK_EQUAL(0, took);
}

TEST(RigTime, SomebodyWhoIsWokenGoesOnOnceTheWakerSleeps) {
  keep();
  const int event = ::eventfd(0, EFD_CLOEXEC);
  in_thread([this, event] {
    struct pollfd polled {
      event, POLLIN, 0
    };
    CHECK_EQUAL(1, wait_for(*state, &polled, 1, kHour));
    CHECK_EQUAL(POLLIN, polled.revents);
    CHECK_EQUAL(1'000'010 * kMs, now());
    tell("woken");
  });
  in_thread([this, event] {
    sleep(10 * kMs);
    CHECK_EQUAL(0, ::eventfd_write(event, 1));
    work(5 * kMs);
    tell("waker");
    sleep(kMs);
  });
  begin();
  join();
  ::close(event);
  STRCMP_EQUAL("waker woken ", all_told().c_str());
}

TEST(RigTime, AWaitThatEndsByItselfLastsUntilItsInstant) {
  keep();
  std::int64_t ended = 0;
  in_thread([this, &ended] {
    CHECK(!wait_in_slices(*state, now() + kHour, [] {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return false;
    }));
    ended = now();
  });
  begin();
  join();
  CHECK_EQUAL(1'000'000 * kMs + kHour, ended);
}

TEST(RigTime, OneWhoLooksAtTheClockOverAndOverWaitsForIt) {
  keep();
  in_thread([this] {
    const std::int64_t until = now() + 10 * kMs;
    while (now() < until) continue;
  });
  begin();
  join();
  CHECK(now() >= 1'000'010 * kMs);
}

TEST(RigTime, ThatIsNoFasterThanTheMachinesIsNeverAheadOfIt) {
  keep(Pace::wall);
  bool ahead = false;
  in_thread([this, &ahead] {
    for (int i = 0; i < 50; ++i) {
      sleep(kMs / 2);
      ahead = ahead || now() > sys::now_ns();
    }
  });
  begin();
  join();
  CHECK(!ahead);
}

TEST(RigTime, NeverGoesBackWhenItIsNoLongerKept) {
  keep();
  in_thread([this] { sleep(kHour); });
  begin();
  join();
  const std::int64_t kept = now();
  keeper.reset();
  CHECK(now() >= kept);
  CHECK(now() < kept + kHour);
}

TEST(RigTime, WaitsEndWhenItIsNoLongerKept) {
  keep();
  // Time has not begun: nothing else would end the wait.
  in_thread([this] { sleep(kMs); });
  std::this_thread::sleep_for(milliseconds(5));
  keeper.reset();
  join();
}

TEST(RigTime, TheClocksOfARepeatableRunStartWhereTheyAreTold) {
  keep();
  CHECK_EQUAL(1'000'000 * kMs, now());
  CHECK_EQUAL(INT64_C(946'685'800) * 1000 * kMs,
              realtime_ns(*state));  // date -d @946685800: 2000-01-01 00:16:40
  CHECK_EQUAL(1'000'000 * kMs, boottime_ns(*state));
}

TEST(RigTime, TheLoopIsHeldAtTheInstantOfAnother) {
  keep();
  std::int64_t at = 0;
  bool passed = false;
  in_thread([&, this] {
    sleep(2 * kMs);
    at = now();
    work(5 * kMs);
    passed = now() > at;
  });
  as_loop([this] {
    const std::int64_t until = now() + 4 * kMs;
    while (now() < until) continue;
  });
  begin();
  join();
  CHECK_EQUAL(1'000'002 * kMs, at);
  CHECK(!passed);
}

TEST(RigTime, WhatTakesTheCoreFromTheLoopCostsNothing) {
  keep();
  std::array<std::int64_t, 2> took{};
  as_loop([&took, this] {
    for (std::int64_t& each : took) {
      const std::int64_t begun = now();
      work(10 * kMs);
      each = now() - begun;
    }
  });
  begin();
  join();
  CHECK(took[0] > 0 && took[0] < 1'000);
  CHECK_EQUAL(took[0], took[1]);
}

TEST(RigTime, TheLoopWakesALittleAfterItsInstant) {
  keep();
  as_loop([this] {
    for (int i = 0; i < 100; ++i) {
      const std::int64_t begun = now();
      CHECK_EQUAL(0, wait_for(*state, nullptr, 0, kMs));
      const std::int64_t late = now() - begun - kMs;
      CHECK(late >= 0);
      CHECK(late <= kLongestLatency + 1'000);
    }
  });
  begin();
  join();
}

TEST(RigTime, WhatTheLoopLeavesForOthersReachesThemWhenItSleeps) {
  keep();
  const int event = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  std::uint64_t early = 0;
  std::uint64_t read_later = 0;
  as_loop([&, this] {
    CHECK(put_off_write(event, 2));
    CHECK(put_off_write(event, 3));
    early = ::eventfd_read(event, &early) == 0 ? early : 0;
    wait_for(*state, nullptr, 0, kMs);
    CHECK_EQUAL(0, ::eventfd_read(event, &read_later));
  });
  begin();
  join();
  ::close(event);
  CHECK_EQUAL(0U, early);
  CHECK_EQUAL(5U, read_later);
}

TEST(RigTime, OnlyTheLoopPutsItsWritesOff) { CHECK(!put_off_write(1, 1)); }

TEST(RigTime, TheRigSeesAChangeBeforeTheLoopGoesOn) {
  keep();
  std::atomic<bool> ends{false};
  std::int64_t seen_at = 0;
  in_thread([&, this] {
    std::uint64_t position = 0;
    while (!ends) {
      const std::uint32_t wake = state->wake.load();
      if (newest(*state) != position) {
        position = newest(*state);
        seen_at = now();
      }
      sleep_as_rig(*state, position, wake, now() + kMs);
    }
  });
  std::int64_t changed_at = 0;
  std::int64_t next = 0;
  as_loop([&, this] {
    wait_for(*state, nullptr, 0, kMs);
    changed_at = now();
    change_line(*state, 3, drive_edit(1), Cause::set, changed_at);
    next = now();
    ends = true;
    wait_for(*state, nullptr, 0, 10 * kMs);
  });
  begin();
  join();
  CHECK_EQUAL(changed_at, seen_at);
  CHECK(next > changed_at);
}

TEST(RigTime, GoesOnWithoutALoopThatLooksAtTheClockNoMore) {
  keep();
  std::atomic<bool> ends{false};
  as_loop([&ends] {
    while (!ends) continue;
  });
  in_thread([this, &ends] {
    sleep(kHour);
    ends = true;
  });
  begin();
  join();
  CHECK_EQUAL(1'000'000 * kMs + kHour, now());
}

TEST_GROUP(ThreadStates) {
  ThreadStates states{own_thread()};
  std::atomic<bool> ends{false};

  bool all_asleep_soon() {
    return wait_until([this] { return states.all_asleep(); }, 60s);
  }
};

TEST(ThreadStates, NobodyIsAsleep) {
  states.watch({});
  CHECK(states.all_asleep());
}

TEST(ThreadStates, TheCallersOwnThreadDoesNotCount) {
  states.watch({::getpid()});
  CHECK(all_asleep_soon());
}

TEST(ThreadStates, AThreadThatWorksIsFoundWhenItBeginsAndEnds) {
  states.watch({::getpid()});
  CHECK(all_asleep_soon());
  std::atomic<pid_t> tid{0};
  std::thread worker([&] {
    tid = own_thread();
    while (!ends) continue;
  });
  CHECK(wait_until([&] { return !states.all_asleep() && states.running() == tid; }, 60s));
  CHECK(wait_until([&] { return states.consumed_ns(::getpid(), tid) > 1'000'000; }, 60s));
  ends = true;
  worker.join();
  CHECK(all_asleep_soon());
}

TEST(ThreadStates, AProgramThatIsStoppedOrDeadSleeps) {
  const pid_t child = ::fork();
  if (child == 0)
    for (;;) continue;
  states.watch({child});
  CHECK(wait_until([&] { return !states.all_asleep(); }, 60s));
  ::kill(child, SIGSTOP);
  CHECK(all_asleep_soon());
  ::kill(child, SIGCONT);
  CHECK(wait_until([&] { return !states.all_asleep(); }, 60s));
  ::kill(child, SIGKILL);
  CHECK(all_asleep_soon());
  ::waitpid(child, nullptr, 0);
  CHECK(all_asleep_soon());
}
