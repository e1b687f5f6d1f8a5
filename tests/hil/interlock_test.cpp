// The pitching machine fires only with the key on, the e-stop released and a token that is still good. The
// chip's recorded changes are the judge.
#include <functional>
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

constexpr auto kNothingHappens = 600ms;  ///< a refused shot's trigger would have come after 0.3 s

std::size_t shots_fired(const RigFixture& bench) { return read_log(bench.journal()).shots.size(); }

/// Between two instants.
struct Span {
  std::string what;
  std::int64_t from_ns;
  std::int64_t to_ns = INT64_MAX;
};

void expect_untouched(const LineChanges& changes, const Span& span, const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    LONGS_EQUAL_TEXT(0, changes.rises(line, span.from_ns, span.to_ns), (span.what + ": " + line).c_str());
}

/// A train of 5 ms with a trigger that is due more than a second after the first flash.
strobe_msgs::command_t late_trigger(RawHost& host, std::int64_t token) {
  strobe_msgs::command_t fire = host.fire_command(token, false);
  fire.plan.period_ns = 5 * kMs;
  fire.plan.shutter_open_ns = 1'500 * kMs;
  fire.plan.impact_at_ns = 1'400 * kMs;
  return fire;
}

/// Stops a shot after its first flash, well before its trigger is due. It must end aborted. Returns the span from
/// the flash to the shutter's closing.
Span stop_in_mid_train(const RigFixture& bench, RawHost& host, const std::string& how,
                       const std::function<void(LineWatcher&)>& stop) {
  LineWatcher watch(bench.chip_dir());
  const std::int64_t flash_ns =
      host.fire_until_flash(watch, [&](std::int64_t token) { return late_trigger(host, token); });
  CHECK_TEXT(flash_ns != 0, bench.log().c_str());
  stop(watch);
  const auto closed = [&] { return !host.shots().empty() && host.shots().back().shutter_off_ns > flash_ns; };
  CHECK_TEXT(host.wait(closed, kLongestWait), bench.log().c_str());
  CHECK_TEXT(host.shots().back().aborted, how.c_str());
  return {how, flash_ns, host.shots().back().shutter_off_ns};
}

/// Lines that pull up until asked otherwise, as lines 0 to 8 of a Raspberry Pi: an open e-stop would read as
/// released there and an open key as on.
RigFixtureOptions lines_that_pull_up() {
  RigFixtureOptions options;
  options.scene_addition = "[chip]\nreset_pull = \"up\"\n";
  return options;
}

const std::vector<std::pair<std::string, std::string>> kWires{
    {"KEY", "the key is off, or its wire is broken"},
    {"ESTOP", "the e-stop is pressed, or its wire is broken"}};

}  // namespace

TEST_GROUP(Interlock){};

TEST(Interlock, FiresTheMachineOnceAShotWhenAllIsWellAndElseRefusesInWords) {
  ReadyRig bench;
  const auto fired = ran(bench.fire(1, 0));
  const std::size_t live = shots_fired(bench);
  const LineWatcher clock(bench.chip_dir());
  const std::int64_t dry_from = clock.now_ns();
  const auto dry = ran(bench.fire(1, 0, {"--dry"}));
  const std::size_t all = shots_fired(bench);
  std::vector<Span> refusals;
  for (const auto& [line, word] : {std::pair{"KEY", "key"}, std::pair{"ESTOP", "stop"}}) {
    Span refused{line, clock.now_ns()};
    bench.drive(std::string(line) + "=0");
    const auto tried = bench.refused(bench.fire(1, 0), word);
    CHECK_TEXT(tried.status == ExitStatus({1, 0}), tried.err.c_str());
    CHECK_TEXT(tried.err.find(word) != std::string::npos, (tried.err + bench.log()).c_str());
    refused.to_ns = clock.now_ns();
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
  ReadyRig bench(options);
  RawHost host(bench);
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
  CHECK(host.wait([&] { return host.saw(strobe_msgs::event_t::DISARMED); }, kLongestWait));
  host.send(host.fire_command(expired, false));
  const std::int64_t token = host.arm();
  CHECK(token != 0);
  host.send(host.fire_command(token + 1, false));
  host.send(host.fire_command(expired, false));
  host.listen(100ms);
  CHECK(host.saw(strobe_msgs::event_t::REFUSED));
  LONGS_EQUAL(0, host.status().last_shot_id);
  host.send(host.command(strobe_msgs::command_t::DISARM));
  CHECK(host.wait([&] { return host.status().arm_token == 0; }, kLongestWait));
  // The same command however often, and its token again in another.
  const strobe_msgs::command_t fire = host.fire_command(host.arm(), false);
  for (int i = 0; i < 5; ++i) host.send(fire);
  CHECK(host.wait([&] { return !host.shots().empty(); }, kLongestWait));
  for (int i = 0; i < 5; ++i) host.send(fire);
  host.send(host.fire_command(fire.arm_token, false));
  CHECK(host.wait([&] { return host.status().state == strobe_msgs::status_t::SPENT; }, kLongestWait));
  host.listen(kNothingHappens);
  LONGS_EQUAL(1, host.shots().size());
  CHECK(bench.finish().rises("TRIGGER") <= 1);
}

TEST(Interlock, FiresNothingThatWasLongerThanASecondOnItsWay) {
  ReadyRig bench;
  RawHost host(bench);
  CHECK(host.wait_status());
  const std::int64_t token = host.arm();
  CHECK(token != 0);
  strobe_msgs::command_t late = host.fire_command(token, false);
  late.sent_boot_time_ns -= 1'001 * kMs;
  host.send(late);
  CHECK(host.wait([&] { return host.saw(strobe_msgs::event_t::REFUSED); }, kLongestWait));
  STRCMP_CONTAINS("after it was sent, and is good for 1000 ms", host.events().back().detail.c_str());
  LONGS_EQUAL(0, host.status().last_shot_id);
  strobe_msgs::command_t disarm = host.command(strobe_msgs::command_t::DISARM);
  disarm.sent_boot_time_ns = 0;
  host.send(disarm);
  CHECK(host.wait([&] { return host.status().arm_token == 0; }, kLongestWait));
  LONGS_EQUAL(0, bench.finish().rises("TRIGGER"));
}

TEST(Interlock, StopsAShotByKeyEStopAndDisarm) {
  ReadyRig bench;
  RawHost host(bench);
  CHECK(host.wait_status());
  std::vector<Span> stopped;
  for (const std::string line : {"KEY", "ESTOP"}) {
    stopped.push_back(
        stop_in_mid_train(bench, host, line, [&](LineWatcher& watch) { watch.drive(line, 0); }));
    bench.drive(line + "=1");
    CHECK(host.wait([&] { return host.status().key_active && !host.status().estop_active; }, kLongestWait));
  }
  stopped.push_back(stop_in_mid_train(
      bench, host, "disarm", [&](LineWatcher&) { host.send(host.command(strobe_msgs::command_t::DISARM)); }));
  const LineChanges changes = bench.finish();
  for (const Span& shot : stopped) expect_untouched(changes, shot, {"TRIGGER"});
  LONGS_EQUAL(host.shots().size(), read_log(bench.journal()).shots.size());
}

TEST(Interlock, StopsAShotWhenAWireBreaks) {
  ReadyRig bench(lines_that_pull_up());
  RawHost host(bench);
  CHECK(host.wait_status());
  std::vector<Span> stopped;
  for (const auto& [line, words] : kWires) {
    stopped.push_back(
        stop_in_mid_train(bench, host, line, [&](LineWatcher& watch) { watch.open_wire(line); }));
    CHECK_TEXT(host.wait([&] { return host.status().message == words; }, kLongestWait), words.c_str());
    bench.drive(line + "=1");
    CHECK(host.wait([&] { return host.status().key_active && !host.status().estop_active; }, kLongestWait));
  }
  const LineChanges changes = bench.finish();
  for (const Span& shot : stopped) expect_untouched(changes, shot, {"TRIGGER"});
}

TEST(Interlock, EndsAnArmingWhenAWireBreaks) {
  ReadyRig bench(lines_that_pull_up());
  RawHost host(bench);
  CHECK(host.wait_status());
  for (const auto& [line, words] : kWires) {
    const std::int64_t token = host.arm();
    CHECK(token != 0);
    bench.drive(line + "=open");
    CHECK_TEXT(host.wait([&] { return host.status().message == words; }, kLongestWait), words.c_str());
    LONGS_EQUAL(0, host.status().arm_token);
    host.send(host.fire_command(token, false));
    host.listen(kNothingHappens);
    bench.drive(line + "=1");
    CHECK(host.wait([&] { return host.status().key_active && !host.status().estop_active; }, kLongestWait));
  }
  LONGS_EQUAL(0, host.status().last_shot_id);
  expect_untouched(bench.finish(), {"all the time", 0}, kOutputs);
}

TEST(Interlock, IsNotArmedWithAWireThatWasBrokenAtTheStart) {
  for (const auto& [line, words] : kWires) {
    RigFixtureOptions options = lines_that_pull_up();
    options.shell = "'" + program("strobe-sim").string() + "' drive --chip-dir \"$STROBE_GPIOCHIP_DIR\" " +
                    line + "=open && exec \"$@\"";
    ReadyRig bench(options);
    const auto tried = bench.refused(bench.fire(1, 0), words);
    CHECK_TEXT(tried.status == ExitStatus({1, 0}), tried.err.c_str());
    STRCMP_CONTAINS(words.c_str(), tried.err.c_str());
    expect_untouched(bench.finish(), {line, 0}, kOutputs);
  }
}
