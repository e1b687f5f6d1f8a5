// From the e-stop to all outputs inactive in a millisecond at most, whatever the loop is doing: asleep,
// spinning before a flash, within a lamp's or the machine's pulse, in a fast train of single lamps, or
// closing a shot. The chip's recorded changes are the judge; a freeze detector tells which attempts the machine
// itself stood still in.
#include <cstdio>
#include <functional>
#include <vector>

#include "tests/benchmarks/timing/freeze_detector.hpp"
#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/skip.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::monotonic_now_ns;

namespace {

constexpr std::int64_t kUs = 1'000;
constexpr std::int64_t kLimitNs = kMs;
/// Presses of each situation on one bench. Those in a freeze that the detector saw do not count, nor do shots
/// that one rejected before. One in time must be left, and none may be late: else all is tried on another
/// bench, since a freeze of less than the detector notices may have come between; so often at most.
constexpr int kPresses = 3;
constexpr int kBenches = 4;
constexpr int kDetectorPriority = 70;  // below the loop's

void busy_wait(std::int64_t until_ns) {
  while (monotonic_now_ns() < until_ns) continue;
}

struct Situation {
  const char* name;
  bool fast_train;
  /// Gives the instant at which to press, having waited for what comes before it; 0: it never came.
  std::function<std::int64_t(LineWatcher&)> instant;
};

std::int64_t flash(LineWatcher& watch, int n) { return watch.wait_for_nth("STROBE_A", 1, n, 3s); }
std::int64_t after(std::int64_t event_ns, std::int64_t later_ns) {
  return event_ns == 0 ? 0 : event_ns + later_ns;
}

// The train's period is 3 ms; the loop spins for the last 0.2 ms before each flash, a lamp's pulse is 50 us.
const std::vector<Situation>& situations() {
  static const std::vector<Situation> all{
      {"asleep, shutter open, before the first flash", false,
       [](LineWatcher& watch) { return after(watch.wait_for("SHUTTER", 1, 3s), 5 * kMs); }},
      {"asleep between two flashes", false,
       [](LineWatcher& watch) { return after(flash(watch, 5), 1500 * kUs); }},
      {"spinning before a flash", false,
       [](LineWatcher& watch) { return after(flash(watch, 5), 2900 * kUs); }},
      {"just before a flash", false, [](LineWatcher& watch) { return after(flash(watch, 5), 2995 * kUs); }},
      {"within a lamp's pulse", false, [](LineWatcher& watch) { return after(flash(watch, 5), 3020 * kUs); }},
      {"within the machine's pulse", false,
       [](LineWatcher& watch) { return after(watch.wait_for("TRIGGER", 1, 3s), 8 * kMs); }},
      {"in a fast train of single lamps", true,
       [](LineWatcher& watch) { return after(flash(watch, 20), 777 * kUs); }},
      {"closing, after the last flash", false,
       [](LineWatcher& watch) { return after(watch.wait_for("SHUTTER", 0, 3s), 500 * kUs); }},
  };
  return all;
}

strobe_msgs::command_t shot(RawHost& host, std::int64_t token, bool fast_train) {
  strobe_msgs::command_t fire = host.fire_command(token, false);
  fire.plan.shutter_open_ns = 120 * kMs;
  fire.plan.impact_at_ns = 60 * kMs;
  if (!fast_train) return fire;
  for (int k = 0; k < 100; ++k) {
    strobe_msgs::coded_flash_t flash;
    flash.offset_ns = k * 750 * kUs;
    flash.lamps = k % 2 == 0 ? 1 : 2;
    fire.plan.code.push_back(flash);
  }
  fire.plan.code_count = static_cast<std::int32_t>(fire.plan.code.size());
  return fire;
}

struct Press {
  const Situation* situation;
  std::int64_t pressed = 0, released = 0;
};

/// One shot that is stopped; nothing if a freeze had aborted it before.
Press stop_a_shot(RawHost& host, const RigFixture& bench, const Situation& situation) {
  Press press{&situation};
  const std::int64_t token = host.arm();
  CHECK_TEXT(token != 0, host.status().message.c_str());
  const std::size_t shots = host.shots().size();
  LineWatcher watch(bench.chip_dir());  // sees nothing of the shot before
  host.send(shot(host, token, situation.fast_train));
  const std::int64_t due = situation.instant(watch);
  if (due != 0) {
    busy_wait(due);
    press.pressed = monotonic_now_ns();
    watch.drive("ESTOP", 0);
  }
  const bool fired = host.wait([&] { return host.shots().size() > shots; }, 5s);
  CHECK_TEXT(fired, (situation.name + (": " + host.events().back().detail)).c_str());
  // Nothing may become active as long as it is pressed, not by a command either.
  if (due != 0) host.send(host.command(strobe_msgs::command_t::ARM));
  host.listen(20ms);
  press.released = monotonic_now_ns();
  watch.drive("ESTOP", 1);
  CHECK(host.wait([&] { return !host.status().estop_active; }, kLongestWait));
  return press;
}

struct Session {
  std::vector<Press> presses;
  std::vector<strobe::benchmarks::timing::Freeze> freezes;
  strobe::Duration watched;
  LineChanges changes;
};

Session press_in_all_situations() {
  RigFixtureOptions options;
  options.sim_options = {"--time", "real"};
  options.rig_edits = {{"lag_ms = 310", "lag_ms = 70"}};  // shots that begin soon; nobody looks at the ball
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  strobe::benchmarks::timing::FreezeDetector detector(kDetectorPriority);
  const std::int64_t begin_ns = monotonic_now_ns();
  std::vector<Press> presses;
  for (int round = 0; round < kPresses; ++round)
    for (const Situation& situation : situations()) presses.push_back(stop_a_shot(host, bench, situation));
  auto freezes = detector.stop();
  const strobe::Duration watched{monotonic_now_ns() - begin_ns};
  return {std::move(presses), std::move(freezes), watched, bench.finish()};
}

/// Whether one was answered in time and none late outside freezes.
bool answered_in_time(const Session& session, const Situation& situation) {
  int in_time = 0, frozen = 0, late = 0;
  std::printf("e-stop %s: inactive after", situation.name);
  for (const Press& press : session.presses) {
    if (press.situation != &situation || press.pressed == 0) continue;
    const std::int64_t safe = session.changes.inactive_from(press.pressed, press.released);
    CHECK_TEXT(safe != INT64_MAX, situation.name);
    const bool froze = within_freeze(session.freezes, strobe::from_ns(press.pressed), strobe::from_ns(safe));
    (safe - press.pressed <= kLimitNs ? in_time : froze ? frozen : late) += 1;
    std::printf(" %.0f", static_cast<double>(safe - press.pressed) * 1e-3);
  }
  std::printf(" us (%d in freezes)\n", frozen);
  return in_time > 0 && late == 0;
}

/// The chip's changes around a press, for the eye.
void show(const Session& session, const Press& press) {
  for (const LineChange& change : session.changes.all()) {
    const std::int64_t at = change.time_ns - press.pressed;
    if (at < -7 * kMs || at > 3 * kMs) continue;
    std::printf("%+10.1f us  %-8s %d  %s\n", static_cast<double>(at) * 1e-3, change.line.c_str(),
                change.level, change.cause.c_str());
  }
}

}  // namespace

TEST_GROUP(EStop){};

TEST(EStop, MakesAllOutputsInactiveWithinAMillisecondFromAnyState) {
  bool well = false, frozen = false;
  for (int attempt = 0; attempt < kBenches && !well; ++attempt) {
    const Session session = press_in_all_situations();
    frozen = frozen || stands_still_often(session.freezes, session.watched);
    well = true;
    for (const Situation& situation : situations()) well = answered_in_time(session, situation) && well;
    if (well) show(session, session.presses[1]);
  }
  if (!well && frozen)
    return strobe::testing::skip("the machine stood still too often to judge a millisecond by");
  CHECK(well);
}
