// The pitching machine fires only with the key on, the e-stop released and a token that is still good. The
// chip's recorded changes are the judge.
#include <functional>
#include <string>
#include <vector>

#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;
using strobe::testing::monotonic_now_ns;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr auto kNothingHappens = 600ms;  ///< a refused shot's trigger would have come after 0.3 s

void expect_ready(RigFixture& bench) {
  if (!bench.ready()) FAIL(("strobed did not come up:\n" + bench.log()).c_str());
}

std::size_t shots_fired(const RigFixture& bench) { return read_log(bench.journal()).shots.size(); }

/// A shot whose trigger lies 335 ms after the shutter's line, in the middle of the train.
strobe_msgs::command_t late_trigger(RawHost& host) {
  const std::int64_t token = host.arm();
  CHECK_TEXT(token != 0, host.status().message.c_str());
  strobe_msgs::command_t fire = host.fire_command(token, false);
  fire.plan.shutter_open_ns = 800 * kMs;
  fire.plan.impact_at_ns = 600 * kMs;
  return fire;
}

/// Stops a shot before its trigger's instant; it must end aborted. Where the machine itself stood still
/// before the first flash, another is fired.
void stop_in_mid_train(RigFixture& bench, RawHost& host, const std::function<void(LineWatcher&)>& stop) {
  LineWatcher watch(bench.chip_dir());
  bool flashed = false;
  for (int attempt = 0; attempt < 5 && !flashed; ++attempt) {
    const std::size_t shots = host.shots().size();
    host.send(late_trigger(host));
    flashed = watch.wait_for("STROBE_A", 1, 2s) != 0;
    if (flashed) stop(watch);
    CHECK(host.wait([&] { return host.shots().size() > shots; }, 10s));
    CHECK(host.shots().back().aborted);
  }
  CHECK(flashed);
}

/// Between two instants.
struct Span {
  std::string what;
  std::int64_t from_ns = monotonic_now_ns();
  std::int64_t to_ns = INT64_MAX;
};

void expect_untouched(const LineChanges& changes, const Span& span, const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    LONGS_EQUAL_TEXT(0, changes.rises(line, span.from_ns, span.to_ns), (span.what + ": " + line).c_str());
}

}  // namespace

TEST_GROUP(Interlock){};

TEST(Interlock, FiresTheMachineOnceAShotWhenAllIsWellAndElseRefusesInWords) {
  RigFixture bench;
  expect_ready(bench);
  const auto fired = strobe::testing::run_process(bench.fire(1, kRetries), 60s);
  CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
  const std::size_t live = shots_fired(bench);
  const std::int64_t dry_from = monotonic_now_ns();
  const auto dry = strobe::testing::run_process(bench.fire(1, kRetries, {"--dry"}), 60s);
  CHECK_TEXT(dry.status == ExitStatus({0, 0}), dry.err.c_str());
  const std::size_t all = shots_fired(bench);
  std::vector<Span> refusals;
  for (const auto& [line, word] : {std::pair{"KEY", "key"}, std::pair{"ESTOP", "stop"}}) {
    Span refused{line};
    bench.drive(std::string(line) + "=0");
    const auto tried = strobe::testing::run_process(bench.fire(1, 0, {"--wait", "1"}), 30s);
    CHECK_TEXT(tried.status == ExitStatus({1, 0}), tried.err.c_str());
    CHECK_TEXT(tried.err.find(word) != std::string::npos, tried.err.c_str());
    refused.to_ns = monotonic_now_ns();
    bench.drive(std::string(line) + "=1");
    refusals.push_back(refused);
  }
  const LineChanges changes = bench.finish();
  LONGS_EQUAL(all, changes.rises("SHUTTER"));
  CHECK(changes.rises("TRIGGER") >= 1 && changes.rises("TRIGGER") <= static_cast<int>(live));
  expect_untouched(changes, {"dry", dry_from}, {"TRIGGER"});
  CHECK(changes.rises("STROBE_A", dry_from) > 10);
  for (const Span& refused : refusals) expect_untouched(changes, refused, kOutputs);
}

TEST(Interlock, FiresNoShotWithoutItsTokenNorTwice) {
  RigFixtureOptions options;
  options.rig_edits = {{"expires_s = 30", "expires_s = 1"}};
  RigFixture bench(options);
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  // Nothing of all this may fire.
  host.send(host.fire_command(12345, false));
  strobe_msgs::command_t stale = host.command(strobe_msgs::command_t::ARM);
  stale.boot_id ^= 1;
  host.send(stale);
  host.listen(kNothingHappens);
  CHECK(host.status().arm_token == 0);
  const std::int64_t expired = host.arm();
  CHECK(expired != 0);
  CHECK(host.wait([&] { return host.saw(strobe_msgs::event_t::DISARMED); }, 5s));
  host.send(host.fire_command(expired, false));
  const std::int64_t token = host.arm();
  CHECK(token != 0);
  host.send(host.fire_command(token + 1, false));
  host.send(host.fire_command(expired, false));
  host.listen(100ms);
  CHECK(host.saw(strobe_msgs::event_t::REFUSED));
  LONGS_EQUAL(0, host.status().last_shot_id);
  host.send(host.command(strobe_msgs::command_t::DISARM));
  CHECK(host.wait([&] { return host.status().arm_token == 0; }, 5s));
  // The same command however often, and its token again in another.
  const strobe_msgs::command_t fire = host.fire_command(host.arm(), false);
  for (int i = 0; i < 5; ++i) host.send(fire);
  CHECK(host.wait([&] { return !host.shots().empty(); }, 10s));
  for (int i = 0; i < 5; ++i) host.send(fire);
  host.send(host.fire_command(fire.arm_token, false));
  CHECK(host.wait([&] { return host.status().state == strobe_msgs::status_t::SPENT; }, 5s));
  host.listen(kNothingHappens);
  LONGS_EQUAL(1, host.shots().size());
  CHECK(bench.finish().rises("TRIGGER") <= 1);
}

TEST(Interlock, StopsAShotByKeyEStopAndDisarm) {
  RigFixture bench;
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  for (const std::string line : {"KEY", "ESTOP"}) {
    stop_in_mid_train(bench, host, [&](LineWatcher& watch) { watch.drive(line, 0); });
    bench.drive(line + "=1");
    CHECK(host.wait([&] { return host.status().key_active && !host.status().estop_active; }, 5s));
  }
  stop_in_mid_train(bench, host,
                    [&](LineWatcher&) { host.send(host.command(strobe_msgs::command_t::DISARM)); });
  const LineChanges changes = bench.finish();
  LONGS_EQUAL(0, changes.rises("TRIGGER"));
  CHECK(changes.rises("SHUTTER") >= 3 && changes.rises("SHUTTER") <= static_cast<int>(host.shots().size()));
  LONGS_EQUAL(host.shots().size(), read_log(bench.journal()).shots.size());
}
