#include "sim/gpiochip/time_keeper.hpp"

#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "tests/support/process.hpp"

#include <CppUTest/TestHarness.h>

using strobe::sim::gpio::ThreadStates;
using strobe::testing::wait_until;
using namespace std::chrono_literals;

namespace {
pid_t own_thread() { return static_cast<pid_t>(::syscall(SYS_gettid)); }
}  // namespace

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
