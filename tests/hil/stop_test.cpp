// A stop ends what began before it, and nothing that returns starts anything: the shipped programs on a simulated rig.
#include <signal.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

/// Far longer than from a release to the next ball where the release starts one (62 ms were seen), and than the restart
/// delay.
constexpr std::chrono::milliseconds kNothingStarts{3000};

void expect_said(const std::string& said, const std::string& words) {
  CHECK_TEXT(said.find(words) != std::string::npos, said.c_str());
}

void expect_no_trigger(LineWatcher& watch) { CHECK_EQUAL(0, watch.wait_for("TRIGGER", 1, kNothingStarts)); }

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
    const std::string status = read_text(thread.path() / "status");
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
  wait_until(
      [&] {
        other = other_defaults(pid, expected, first_waits);
        return other.empty();
      },
      10s);
  CHECK_EQUAL("", other);
}

bool stands_still(pid_t pid) {
  std::istringstream stat(read_text("/proc/" + std::to_string(pid) + "/stat"));
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

TEST_GROUP(Stop){};

TEST(Stop, AnEStopOrAKeyEndsASeriesAndItsReturnStartsNothing) {
  ReadyRig bench;
  const std::string host = bench.folder() / "host";
  for (const auto& [line, words] : {std::pair{"ESTOP", "the e-stop"}, std::pair{"KEY", "the key"}}) {
    LineWatcher watch(bench.chip_dir());
    auto fire = bench.start(bench.strobe(
        {"fire", "--shots", "9", "--retries", "0", "--wait", "60", "--plain", "--session", host + line}));
    CHECK_TEXT(watch.wait_for("TRIGGER", 1, fire) != 0, (fire.err() + bench.log()).c_str());
    watch.drive(line, 0);
    LineWatcher after(bench.chip_dir());
    watch.drive(line, 1);
    expect_no_trigger(after);
    CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
    expect_said(fire.err(), std::string("the series ends: ") + words);
    expect_said(fire.err(), "go on with: strobe fire --resume");
    // The one act that is asked for.
    auto resumed = bench.start(bench.strobe({"fire", "--resume", "--session", host + line, "--plain"}));
    LineWatcher again(bench.chip_dir());
    CHECK_TEXT(again.wait_for("TRIGGER", 1, resumed) != 0, resumed.err().c_str());
    resumed.signal(SIGQUIT);
    resumed.wait(kLongestWait);
  }
}

TEST(Stop, NothingBeginsWithTheEStopPressedNorWhenItIsReleasedThen) {
  ReadyRig bench;
  LineWatcher watch(bench.chip_dir());
  watch.drive("ESTOP", 0);
  RawHost host(bench);
  CHECK(host.wait([&] { return host.status().estop_active; }, kLongestWait));
  auto fire = bench.start(bench.fire(1, 0, {"--wait", "60"}));
  CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
  expect_said(fire.err(), "release it, then give the command again");
  watch.drive("ESTOP", 1);
  expect_no_trigger(watch);
}

TEST(Stop, ADisarmOfAHostThatDoesNotFireEndsAnothersSeries) {
  ReadyRig bench;
  LineWatcher watch(bench.chip_dir());
  auto fire = bench.start(bench.fire(9, 0));
  CHECK_TEXT(watch.wait_for("TRIGGER", 1, fire) != 0, fire.err().c_str());
  RawHost other(bench);
  CHECK(other.wait_status());
  other.send(other.command(strobe_msgs::command_t::DISARM));
  CHECK(other.wait([&] { return other.status().state == strobe_msgs::status_t::STOPPED; }, kLongestWait));
  LineWatcher after(bench.chip_dir());
  expect_no_trigger(after);
  CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
}

TEST(Stop, ADisarmThatNobodyAnswersIsShownAsNotConfirmedAndGoneOnWith) {
  ReadyRig bench;
  LineWatcher watch(bench.chip_dir());
  auto fire = bench.start(bench.fire(9, 0));
  CHECK_TEXT(watch.wait_for("SHUTTER", 1, fire) != 0, fire.err().c_str());
  // The receiving thread and the publisher stand still with all of the worker: what is sent then is answered by nobody.
  const pid_t guardian = bench.guardian(), worker = bench.worker();
  kill(guardian, SIGSTOP);
  kill(worker, SIGSTOP);
  fire.signal(SIGQUIT);
  CHECK_TEXT(fire.wait_for_err("DISARM NOT CONFIRMED", kLongestWait), fire.err().c_str());
  kill(worker, SIGCONT);
  kill(guardian, SIGCONT);
  CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
  LineWatcher after(bench.chip_dir());
  expect_no_trigger(after);
}

// What signals do to strobed: each one is a stop in good order, ignored, or the end of a worker that makes its outputs
// inactive first, as the guardian then does again (tests of Death); and no terminal's signal reaches both processes.

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
  ReadyRig bench;
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
