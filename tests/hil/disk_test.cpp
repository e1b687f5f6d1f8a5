// The disk under the journal: full, or the journal taken away in the middle of a shot. Firing is refused with
// the reason; a shot that runs ends as planned, its outputs safe. The disk is a small one of the bench's own,
// in a mount namespace that only strobed sees.
#include <csignal>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <string>

#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
using strobe_msgs::command_t;

namespace {

const char* const kSmallDisk =
    "exec unshare -m sh -c 'mount -t tmpfs -o size=300k none \"$5\" || exit 77; exec \"$@\"' sh \"$@\"";

RigFixtureOptions small_disk() {
  RigFixtureOptions options;
  options.shell = kSmallDisk;
  options.rig_edits = kShortExposure;
  return options;
}

/// A folder as strobed sees it.
std::filesystem::path seen_by_strobed(RigFixture& bench, const std::filesystem::path& path) {
  return "/proc/" + std::to_string(bench.worker()) + "/root" + path.string();
}

void enlarge_disk(RigFixture& bench) {
  const auto done = run_process({{"nsenter", "-t", std::to_string(bench.worker()), "-m", "mount", "-o",
                                  "remount,size=16m", bench.session()},
                                 {},
                                 {},
                                 {}},
                                5s);
  CHECK_TEXT(done.status == ExitStatus({0, 0}), (done.err + bench.log()).c_str());
}

Command fire_elsewhere(RigFixture& bench, const std::vector<std::string>& more) {
  std::vector<std::string> words{
      "fire",  "--shots", "1", "--retries", "0", "--session", bench.folder() / "host",
      "--json"};
  words.insert(words.end(), more.begin(), more.end());
  return bench.strobe(std::move(words));
}

/// A refusal cannot be journalled, so that it is not published either; the status has said why. Judged by one
/// of later than the command, once that of the shot before is no longer on its way.
void expect_no_token(const RigFixture& bench, RawHost& host) {
  CHECK(host.wait([&] { return host.status().arm_token == 0; }, kLongestWait));
  const std::int64_t sent_ns = LineWatcher(bench.chip_dir()).now_ns();
  host.send(host.command(strobe_msgs::command_t::ARM));
  CHECK(host.wait([&] { return host.status().mono_ns > sent_ns + 100'000'000; }, kLongestWait));
  LONGS_EQUAL(0, host.status().arm_token);
}

/// As a shell runs it; the command is "$@".
Command through_shell(const std::string& script, const Command& command) {
  Command shell = command;
  shell.arguments = {"sh", "-c", script, "sh"};
  shell.arguments.insert(shell.arguments.end(), command.arguments.begin(), command.arguments.end());
  return shell;
}

Command fire_shots_elsewhere(RigFixture& bench, int shots) {
  return bench.strobe({"fire", "--shots", std::to_string(shots), "--retries", "0", "--session",
                       bench.folder() / "host", "--json"});
}

/// Of strobed: a pipe of its own that holds 64 KiB already and that nobody reads.
const char* const kBlocked =
    "mkfifo \"$5/../stderr\" && exec 3<>\"$5/../stderr\" && dd if=/dev/zero bs=4096 count=16 >&3 2>/dev/null "
    "&& "
    "exec \"$@\" 2>&3";

}  // namespace

TEST_GROUP(Disk){};

TEST(Disk, FullOrTakenAwayItRefusesShotsWithTheReasonAndARunningOneEndsSafely) {
  RigFixture bench(small_disk());
  if (!bench.ready()) {
    // Without the right to mount there is no disk of its own to fill.
    if (bench.sim().wait(0ms) == ExitStatus({77, 0})) return;
    FAIL(("strobed did not come up:\n" + bench.log()).c_str());
  }
  RawHost host(bench);
  CHECK(host.wait_status());
  CHECK_FALSE(host.status().journal_ok);
  STRCMP_CONTAINS("no room for another shot: No space left on device", host.status().message.c_str());
  expect_no_token(bench, host);
  const auto refused = bench.refused(fire_elsewhere(bench, {}), "no room for another shot");
  CHECK_EQUAL(ExitStatus({1, 0}), refused.status);
  STRCMP_CONTAINS("no room for another shot", refused.err.c_str());

  enlarge_disk(bench);
  CHECK(host.wait([&] { return host.status().journal_ok != 0; }, kLongestWait));
  const auto fired = ran(fire_elsewhere(bench, {"--wait", "20"}));

  LineWatcher watch(bench.chip_dir());
  Process last = bench.start(fire_elsewhere(bench, {"--wait", "20"}));
  const std::int64_t opened = watch.wait_for("SHUTTER", 1, 20s);
  CHECK(opened != 0);
  for (const auto& entry : std::filesystem::directory_iterator(seen_by_strobed(bench, bench.session())))
    std::filesystem::remove(entry.path());
  CHECK(watch.wait_for("SHUTTER", 0, 5s) != 0);
  CHECK(host.wait([&] { return !host.status().journal_ok; }, kLongestWait));
  STRCMP_CONTAINS("the journal was removed; restart strobed", host.status().message.c_str());
  expect_no_token(bench, host);
  last.signal(SIGINT);
  last.wait(20s);
  const LineChanges changes = bench.finish();
  CHECK(changes.rises("TRIGGER", opened) <= 1);
  CHECK(changes.rises("STROBE_A", opened) > 10);
  CHECK(changes.outputs_safe_from(opened) < INT64_MAX);
}

// The shipped `strobe fire` on a disk that fails: a file that may not grow, a standard output that takes nothing, a
// folder that is removed. What a person is told, and the exit status.

TEST_GROUP(Storage) {
  RigFixture bench{short_shots()};
  void setup() override { expect_ready(bench); }
};

TEST(Storage, ALogThatMayNotGrowEndsTheSeriesWithItsNameTheReasonAndWhatIsMissing) {
  constexpr std::uintmax_t kLimit_bytes = 100 * 1024;
  const CompletedProcess fired =
      run_process(through_shell("ulimit -f 200; exec \"$@\"", fire_shots_elsewhere(bench, 50)),
                  kLongestWait);  // of 512 bytes
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  STRCMP_CONTAINS(".lcmlog: cannot be written: File too large", fired.err.c_str());
  STRCMP_CONTAINS(".lcmlog: not stored: ", fired.err.c_str());
  const auto path = host_log(bench.folder() / "host");
  CHECK(std::filesystem::file_size(path) <= kLimit_bytes);
  lcm::LogFile log(path, "r");
  std::uintmax_t bytes = 0;
  while (const lcm::LogEvent* event = log.readNextEvent())
    bytes += 28 + event->channel.size() + static_cast<std::uintmax_t>(event->datalen);
  LONGS_EQUAL(std::filesystem::file_size(path), bytes);  // whole records, to the last byte
}

TEST(Storage, AStandardOutputThatTakesNothingEndsTheSeries) {
  const auto fired = ran(through_shell("exec \"$@\" >/dev/full", fire_shots_elsewhere(bench, 50)), 1);
  CHECK_TEXT(fired.err.find("standard output: cannot be written: No space left") != std::string::npos,
             (fired.err + bench.log()).c_str());
}

TEST(Storage, AFolderThatIsRemovedUnderItEndsTheSeries) {
  auto fire = bench.start(fire_shots_elsewhere(bench, 50));
  CHECK_TEXT(fire.wait_for_out("vx_td_mps", kLongestWait), fire.err().c_str());
  std::filesystem::remove_all(bench.folder() / "host");
  const auto ended = fire.wait(kLongestWait);
  CHECK_TEXT(ended == ExitStatus({1, 0}), fire.err().c_str());
  STRCMP_CONTAINS("results.csv: is no longer there", fire.err().c_str());
}

// Standard error blocked, as by Ctrl-S or by a pipe that nobody empties: strobed hears and obeys all the same.

TEST_GROUP(BlockedConsole){};

TEST(BlockedConsole, KeepsNeitherACommandNorAStatusNorTheEnd) {
  RigFixtureOptions options;
  options.shell = kBlocked;
  options.strobed_options = {"--verbose"};  // a line for each event
  RigFixture bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  for (int round = 0; round < 3; ++round) {
    host.send_bytes(std::vector<std::uint8_t>(100, 1));  // told of on standard error, too
    CHECK(host.arm() != 0);
    host.send(host.command(command_t::DISARM));
    CHECK(host.wait([&] { return host.status().arm_token == 0; }, kLongestWait));
  }
  CHECK(host.status().rejected_malformed > 0);
  const pid_t guardian = bench.guardian();
  CHECK(guardian != 0);
  kill(bench.worker(), SIGKILL);  // the guardian has something to say, too
  CHECK(wait_until([&] { return bench.guardian() == 0; }, kLongestWait));
  CHECK(bench.finish().outputs_safe_from(0) < INT64_MAX);
}
