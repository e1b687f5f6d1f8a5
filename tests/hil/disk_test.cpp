// The disk under the journal: full, or the journal taken away in the middle of a shot. Firing is refused with
// the reason; a shot that runs ends as planned, its outputs safe. The disk is a small one of the bench's own,
// in a mount namespace that only strobed sees.
#include <csignal>
#include <string>

#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::Command;
using strobe::testing::ExitStatus;
using strobe::testing::Process;

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
  const auto done = strobe::testing::run_process({{"nsenter", "-t", std::to_string(bench.worker()), "-m",
                                                   "mount", "-o", "remount,size=16m", bench.session()},
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
void expect_no_token(RawHost& host) {
  CHECK(host.wait([&] { return host.status().arm_token == 0; }, kLongestWait));
  const std::int64_t sent_ns = strobe::testing::monotonic_now_ns();
  host.send(host.command(strobe_msgs::command_t::ARM));
  CHECK(host.wait([&] { return host.status().mono_ns > sent_ns + 100'000'000; }, kLongestWait));
  LONGS_EQUAL(0, host.status().arm_token);
}

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
  expect_no_token(host);
  const auto refused = bench.refused(fire_elsewhere(bench, {}), "no room for another shot");
  CHECK_EQUAL(ExitStatus({1, 0}), refused.status);
  STRCMP_CONTAINS("no room for another shot", refused.err.c_str());

  enlarge_disk(bench);
  CHECK(host.wait([&] { return host.status().journal_ok != 0; }, kLongestWait));
  const auto fired = strobe::testing::run_process(fire_elsewhere(bench, {"--wait", "20"}), kLongestWait);
  CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());

  LineWatcher watch(bench.chip_dir());
  Process last = bench.start(fire_elsewhere(bench, {"--wait", "20"}));
  const std::int64_t opened = watch.wait_for("SHUTTER", 1, 20s);
  CHECK(opened != 0);
  for (const auto& entry : std::filesystem::directory_iterator(seen_by_strobed(bench, bench.session())))
    std::filesystem::remove(entry.path());
  CHECK(watch.wait_for("SHUTTER", 0, 5s) != 0);
  CHECK(host.wait([&] { return !host.status().journal_ok; }, kLongestWait));
  STRCMP_CONTAINS("the journal was removed; restart strobed", host.status().message.c_str());
  expect_no_token(host);
  last.signal(SIGINT);
  last.wait(20s);
  const LineChanges changes = bench.finish();
  CHECK(changes.rises("TRIGGER", opened) <= 1);
  CHECK(changes.rises("STROBE_A", opened) > 10);
  CHECK(changes.outputs_safe_from(opened) < INT64_MAX);
}
