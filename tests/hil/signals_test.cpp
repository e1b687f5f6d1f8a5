// What signals do to strobed: each one is a stop in good order, ignored, or the end of a worker that makes its outputs
// inactive first, as the guardian then does again (tests of Death); and no terminal's signal reaches both processes.
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <initializer_list>
#include <sstream>
#include <string>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;

namespace {

std::uint64_t bits(std::initializer_list<int> signals) {
  std::uint64_t set = 0;
  for (const int signal : signals) set |= std::uint64_t{1} << (signal - 1);
  return set;
}

/// A set of signals as proc(5) shows it in a thread's status.
std::uint64_t signal_set(const std::string& status, const std::string& name) {
  const std::size_t at = status.find(name + ":\t");
  CHECK_TEXT(at != std::string::npos, name.c_str());
  return std::stoull(status.substr(at + name.size() + 2), nullptr, 16);
}

/// The status of a thread that leaves other signals to their default than these; empty if none does. Not of a
/// worker's first: sigwait(3) takes those that it waits for out of its mask.
std::string other_defaults(pid_t pid, std::uint64_t expected, bool first_waits) {
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    if (first_waits && thread.path().filename() == std::to_string(pid)) continue;
    const std::string status = strobe::testing::read_text(thread.path() / "status");
    if (status.empty()) continue;  // it has ended
    const std::uint64_t handled =
        signal_set(status, "SigBlk") | signal_set(status, "SigIgn") | signal_set(status, "SigCgt");
    if (~handled != expected) return status;
  }
  return "";
}

/// In the end: a thread that begins blocks all signals for a moment.
void expect_left_to_default(pid_t pid, std::uint64_t expected, bool first_waits) {
  std::string other;
  strobe::testing::wait_until(
      [&] {
        other = other_defaults(pid, expected, first_waits);
        return other.empty();
      },
      10s);
  CHECK_EQUAL("", other);
}

bool stands_still(pid_t pid) {
  std::istringstream stat(strobe::testing::read_text("/proc/" + std::to_string(pid) + "/stat"));
  std::string number, program, state;
  stat >> number >> program >> state;
  return state == "T";
}

/// Rig time has a signal of its own for its waits.
RigFixtureOptions in_the_machines_time() {
  RigFixtureOptions options;
  options.sim_options = {"--time", "real"};
  return options;
}

}  // namespace

TEST_GROUP(Signals) {
  RigFixture bench{in_the_machines_time()};
  void setup() override { expect_ready(bench); }
};

TEST(Signals, ThatWouldEndAProcessAreTakenOrIgnoredByEveryThread) {
  const std::uint64_t harmless = bits({SIGCHLD, SIGCONT, SIGURG, SIGWINCH});
  const std::uint64_t beyond_reach = bits({SIGKILL, SIGSTOP});
  expect_left_to_default(bench.guardian(), harmless | beyond_reach, false);
  expect_left_to_default(bench.worker(), harmless | beyond_reach, true);
}

TEST(Signals, OfATerminalReachTheGuardianOnly) {
  CHECK(getsid(bench.worker()) != getsid(bench.guardian()));
  CHECK(getpgid(bench.worker()) != getpgid(bench.guardian()));
}

TEST_GROUP(JobControl){};

TEST(JobControl, StopsNeitherProcessNorShot) {
  RigFixture bench;
  expect_ready(bench);
  RawHost host(bench);
  CHECK(host.wait_status());
  LineWatcher watch(bench.chip_dir());
  const auto shot = [&host](std::int64_t token) { return host.fire_command(token, true); };
  const std::int64_t flash_ns = host.fire_until_flash(watch, shot);
  CHECK(flash_ns != 0);
  for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) {
    for (const pid_t pid : {bench.guardian(), bench.worker()}) {
      kill(pid, signal);
      CHECK(!stands_still(pid));
    }
  }
  const auto closed = [&] { return !host.shots().empty() && host.shots().back().shutter_off_ns > flash_ns; };
  CHECK_TEXT(host.wait(closed, kLongestWait), bench.log().c_str());
  CHECK(bench.worker() != 0);
}
