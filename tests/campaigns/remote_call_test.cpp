// Faults put under another process, seen by that process.
#include "tests/campaigns/remote_call.hpp"

#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sys/mman.h>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <functional>
#include <new>
#include <thread>

#include "tests/support/process.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::ends;
using namespace std::chrono_literals;
using strobe::testing::wait_until;

namespace {

/// What a child process and the test both see.
struct Shared {
  std::atomic<int> turns{0}, result{0}, error{0};
};

}  // namespace

TEST_GROUP(RemoteCall) {
  Shared* const shared =
      new (mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Shared;
  pid_t child = 0;

  void teardown() override {
    if (child > 0) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
    munmap(shared, sizeof(Shared));
  }

  /// A process that does this over and over.
  void start(const std::function<void()>& turn) {
    child = fork();
    if (child == 0) {
      for (;;) {
        turn();
        ++shared->turns;
        usleep(1000);
      }
    }
    CHECK(turns_on());
  }
  bool turns_on() {
    const int before = shared->turns;
    return wait_until([&] { return shared->turns > before + 1; }, 20s);
  }
};

TEST(RemoteCall, ReturnsWhatTheOtherProcessWouldBeToldAndLeavesItAsItWas) {
  start([] {});
  {
    HeldThread thread(child);
    if (!thread.held()) return;  // may not be traced here
    LONGS_EQUAL(child, thread.call(SYS_getpid).value());
    LONGS_EQUAL(-EBADF, thread.call(SYS_close, {12345}).value());
  }
  CHECK(turns_on());
}

TEST(RemoteCall, AHeldThreadStandsStill) {
  start([] {});
  HeldThread thread(child);
  if (!thread.held()) return;
  const int before = shared->turns;
  strobe::testing::sleep_for(20ms);
  LONGS_EQUAL(before, shared->turns);
}

TEST(RemoteCall, ADescriptorIsClosedUnderItsUser) {
  const int null = dup(STDERR_FILENO);
  start([this, null] { shared->result = static_cast<int>(fcntl(null, F_GETFD) >= 0); });
  LONGS_EQUAL(1, shared->result);
  {
    HeldThread thread(child);
    if (!thread.held()) return;
    LONGS_EQUAL(0, thread.call(SYS_close, {null}).value());
  }
  CHECK(turns_on());
  LONGS_EQUAL(0, shared->result);
  close(null);
}

TEST(RemoteCall, ASystemCallFailsAsDrawn) {
  start([this] {
    shared->result = static_cast<int>(syscall(SYS_getppid));
    shared->error = errno;
  });
  LONGS_EQUAL(getpid(), shared->result);
  {
    HeldThread thread(child);
    if (!thread.held()) return;
    CHECK(fail_system_call(thread, child, SYS_getppid, ENOSPC));
  }
  CHECK(turns_on());
  LONGS_EQUAL(-1, shared->result);
  LONGS_EQUAL(ENOSPC, shared->error);
}

TEST(RemoteCall, AThreadEndsAndTheOthersGoOn) {
  child = fork();
  if (child == 0) {
    std::thread other([this] {
      for (;;) {
        ++shared->turns;
        usleep(1000);
      }
    });
    for (;;) usleep(1000);
  }
  CHECK(turns_on());
  CHECK(wait_until([&] { return threads_of(child).size() == 2; }, 20s));
  const pid_t other = threads_of(child).back();
  {
    HeldThread thread(other);
    if (!thread.held()) return;
    thread.end();
  }
  CHECK(wait_until([&] { return threads_of(child) == std::vector<pid_t>{child}; }, 20s));
}
