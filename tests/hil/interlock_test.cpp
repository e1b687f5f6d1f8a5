// The pitching machine fires only with the key on, the e-stop released and a token that is still good. The
// chip's recorded changes are the judge.
#include <string>

#include "tests/hil/bench.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/watch.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;

namespace {

/// The ball comes late in a long exposure, so that the trigger lies 335 ms after the shutter's line.
const std::vector<std::pair<std::string, std::string>> kLateTrigger{
    {"impact_at_ms = 250", "impact_at_ms = 600"}, {"shutter_open_ms = 500", "shutter_open_ms = 800"}};

/// Outputs must be safe this long after key or e-stop changed: the loop wakes at once, a host freeze of up to
/// 170 ms may come between.
constexpr std::int64_t kSafeWithinNs = 250'000'000;

void expect_ready(Bench& bench) {
  if (!bench.ready()) FAIL(("strobed did not come up:\n" + bench.log()).c_str());
}

/// A line turned against firing while nothing happens: no shot, a clear message, no pulse.
void expect_refusal_at_rest(const std::string& line, const std::string& word) {
  Bench bench;
  expect_ready(bench);
  bench.drive(line + "=0");
  const auto fired = strobe::testing::run_to_end(bench.fire(1, 0, {"--wait", "1"}), 30s);
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  CHECK_TEXT(fired.err.find(word) != std::string::npos, fired.err.c_str());
  const LineChanges changes = bench.finish();
  for (const std::string& output : kOutputs) LONGS_EQUAL(0, changes.rises(output));
}

/// The same in the middle of a shot, before the trigger's instant.
void expect_stop_mid_shot(const std::string& line) {
  BenchOptions options;
  options.rig_edits = kLateTrigger;
  Bench bench(options);
  expect_ready(bench);
  LineWatch watch(bench.chip_dir());
  strobe::testing::Process fire = bench.start(bench.fire(1, 0));
  CHECK_TEXT(watch.wait_for("STROBE_A", 1, fire) != 0, fire.err().c_str());
  const std::int64_t stopped = strobe::testing::monotonic_now_ns();
  watch.drive(line, 0);
  CHECK(fire.wait(30s).has_value());
  const LineChanges changes = bench.finish();
  LONGS_EQUAL(0, changes.rises("TRIGGER"));
  LONGS_EQUAL(1, changes.rises("SHUTTER"));
  CHECK(changes.outputs_safe_from(stopped) - stopped < kSafeWithinNs);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(1, journal.shots.size());
  CHECK(journal.shots[0].aborted);
}

}  // namespace

TEST_GROUP(Interlock){};

TEST(Interlock, FiresTheMachineOnceAShotWhenAllIsWell) {
  Bench bench;
  expect_ready(bench);
  const auto fired = strobe::testing::run_to_end(bench.fire(1, 9), 60s);
  CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
  const std::size_t shots = read_log(bench.journal()).shots.size();
  const LineChanges changes = bench.finish();
  LONGS_EQUAL(shots, changes.rises("SHUTTER"));
  CHECK(changes.rises("TRIGGER") >= 1 && changes.rises("TRIGGER") <= static_cast<int>(shots));
}

TEST(Interlock, DryShotsNeverFireTheMachine) {
  Bench bench;
  expect_ready(bench);
  const auto fired = strobe::testing::run_to_end(bench.fire(2, 9, {"--dry"}), 60s);
  CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
  const std::size_t shots = read_log(bench.journal()).shots.size();
  const LineChanges changes = bench.finish();
  CHECK(shots >= 2);
  LONGS_EQUAL(0, changes.rises("TRIGGER"));
  LONGS_EQUAL(shots, changes.rises("SHUTTER"));
  CHECK(changes.rises("STROBE_A") > 10);
}

TEST(Interlock, RefusesWithTheKeyOff) { expect_refusal_at_rest("KEY", "key"); }
TEST(Interlock, RefusesWithTheEmergencyStopPressed) { expect_refusal_at_rest("ESTOP", "stop"); }
TEST(Interlock, StopsAShotWhenTheKeyIsTurnedOff) { expect_stop_mid_shot("KEY"); }
TEST(Interlock, StopsAShotWhenTheEmergencyStopIsPressed) { expect_stop_mid_shot("ESTOP"); }

TEST(Interlock, RefusesATokenThatHasExpired) {
  BenchOptions options;
  options.rig_edits = {{"expires_s = 30", "expires_s = 1"}};
  Bench bench(options);
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  const std::int64_t token = host.arm();
  CHECK(token != 0);
  host.listen(1500ms);
  CHECK(host.saw(strobe_msgs::event_t::DISARMED));
  host.send(host.fire_command(token, false));
  host.listen(1500ms);
  CHECK(host.saw(strobe_msgs::event_t::REFUSED));
  LONGS_EQUAL(0, bench.finish().rises("TRIGGER"));
}

TEST(Interlock, RefusesAGuessedAnUnarmedAndASpentToken) {
  Bench bench;
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  host.send(host.fire_command(12345, false));
  host.listen(500ms);
  const std::int64_t token = host.arm();
  CHECK(token != 0);
  host.send(host.fire_command(token + 1, false));
  host.listen(500ms);
  LONGS_EQUAL(0, host.shots().size());
  const std::int64_t good = host.status().arm_token != 0 ? host.status().arm_token : host.arm();
  host.send(host.fire_command(good, false));
  CHECK(host.wait([&] { return host.shots().size() == 1; }, 10s));
  host.send(host.fire_command(good, false));
  host.listen(1500ms);
  LONGS_EQUAL(1, host.shots().size());
  CHECK(bench.finish().rises("TRIGGER") <= 1);
}

TEST(Interlock, ObeysACommandOnceHoweverOftenItArrives) {
  Bench bench;
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  const strobe_msgs::command_t fire = host.fire_command(host.arm(), false);
  for (int i = 0; i < 5; ++i) host.send(fire);
  CHECK(host.wait([&] { return !host.shots().empty(); }, 10s));
  for (int i = 0; i < 5; ++i) host.send(fire);
  host.listen(1500ms);
  LONGS_EQUAL(1, host.shots().size());
  CHECK(bench.finish().rises("TRIGGER") <= 1);
}

TEST(Interlock, IgnoresCommandsForAnotherBoot) {
  Bench bench;
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  strobe_msgs::command_t stale = host.command(strobe_msgs::command_t::ARM);
  stale.boot_id ^= 1;
  host.send(stale);
  host.listen(1000ms);
  CHECK(host.status().arm_token == 0);
}

TEST(Interlock, AbortsAShotThatIsDisarmed) {
  BenchOptions options;
  options.rig_edits = kLateTrigger;
  Bench bench(options);
  expect_ready(bench);
  RawHost host(bench.lcm_url(), "bench");
  CHECK(host.wait_status());
  strobe_msgs::command_t fire = host.fire_command(host.arm(), false);
  fire.plan.shutter_open_ns = 800'000'000;
  fire.plan.impact_at_ns = 600'000'000;
  host.send(fire);
  CHECK(host.wait([&] { return host.saw(strobe_msgs::event_t::FLASH); }, 10s));
  host.send(host.command(strobe_msgs::command_t::DISARM));
  CHECK(host.wait([&] { return !host.shots().empty(); }, 10s));
  CHECK(host.shots()[0].aborted);
  LONGS_EQUAL(0, bench.finish().rises("TRIGGER"));
}
