// A stop ends what began before it, and nothing that returns starts anything: the shipped programs on a simulated rig.
#include <signal.h>

#include <string>
#include <vector>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;

namespace {

/// Far longer than from a release to the next ball where the release starts one (62 ms were seen), and than the restart
/// delay.
constexpr std::chrono::milliseconds kNothingStarts{3000};

void expect_said(const std::string& said, const std::string& words) {
  CHECK_TEXT(said.find(words) != std::string::npos, said.c_str());
}

void expect_no_trigger(LineWatcher& watch) { CHECK_EQUAL(0, watch.wait_for("TRIGGER", 1, kNothingStarts)); }

}  // namespace

TEST_GROUP(Stop){};

TEST(Stop, AnEStopOrAKeyEndsASeriesAndItsReturnStartsNothing) {
  RigFixture bench;
  expect_ready(bench);
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
  RigFixture bench;
  expect_ready(bench);
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
  RigFixture bench;
  expect_ready(bench);
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
  RigFixture bench;
  expect_ready(bench);
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
