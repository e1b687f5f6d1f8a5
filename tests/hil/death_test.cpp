// However strobed ends in the middle of a train, every output is inactive at once, on chips that keep a dead
// process's lines as they were and on chips that let them go; and its journal can be read to the last event.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/benchmarks/timing/freeze_detector.hpp"
#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/fake_service_manager.hpp"
#include "tests/support/skip.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
using strobe::benchmarks::timing::Freeze;
using strobe::benchmarks::timing::FreezeDetector;

namespace {

/// In the machine's time: a freeze long enough to make a shot late falls into one of five.
constexpr int kFlashAttempts = 10;

/// What is judged here is how prompt strobed is.
const std::vector<std::string> kRealTime{"--time", "real"};
/// Of time in which the machine ran: a virtual one stands still for 10-170 ms in 1-2 % of the time.
constexpr std::int64_t kAtOnce = kMs;
/// Even so the outputs become safe within this.
constexpr std::int64_t kSafeAtAllNs = 1000 * kMs;
constexpr int kWitnessPriority = 90;  // above strobed's: what keeps the witness waiting is none of it
/// A standstill that the witness may have missed, and how many there may be among all ways.
constexpr std::int64_t kUnseenNs =
    (FreezeDetector::kPeriod + FreezeDetector::kLateWakeUp) / strobe::nanoseconds(1);
constexpr int kUnseen = 2;
/// Benches that run at the same time: all but one of them wait.
constexpr std::size_t kAtATime = 6;

enum class Chip { keeps, lets_go };

/// What befalls strobed after the first flash of a shot, and what must follow.
struct Way {
  const char* name;
  Chip chip;
  /// Gives the instant of the end; 0 if the machine had stood still so that the shot was over before.
  std::function<std::int64_t(const RigFixture&, LineWatcher&)> end;
  const char* said;                                                  ///< in its last words
  std::int64_t safe_within_ns = kAtOnce;
  const char* drill = "";
  bool stays_active = false;  ///< on a chip that keeps its lines and can no longer be reached
};

using Victim = pid_t (RigFixture::*)() const;

/// Sent to all of them at once, as a terminal, pkill(1) or a service manager does.
auto sent_to(std::vector<Victim> victims, int signal) {
  return [victims, signal](const RigFixture& bench, LineWatcher&) {
    std::vector<pid_t> pids;
    for (const Victim victim : victims) pids.push_back((bench.*victim)());
    const std::int64_t now = monotonic_now_ns();
    for (const pid_t pid : pids) kill(pid, signal);
    return now;
  };
}
auto to_worker(int signal) { return sent_to({&RigFixture::worker}, signal); }
auto to_guardian(int signal) { return sent_to({&RigFixture::guardian}, signal); }
auto to_both(int signal) { return sent_to({&RigFixture::guardian, &RigFixture::worker}, signal); }
std::int64_t kill_both(const RigFixture& bench, LineWatcher&) {
  const pid_t guardian = bench.guardian(), worker = bench.worker();
  const std::int64_t now = monotonic_now_ns();
  kill(guardian, SIGSTOP);  // so that it does not do its work in between
  kill(worker, SIGKILL);
  kill(guardian, SIGKILL);
  return now;
}
/// Seen from outside: the worker is a zombie or gone.
std::int64_t dies(const RigFixture& bench, LineWatcher&) {
  const pid_t worker = bench.worker();
  CHECK(wait_until([&] { return program_of(worker).empty(); }, kLongestWait));
  return monotonic_now_ns();
}
std::int64_t hangs(const RigFixture&, LineWatcher&) { return monotonic_now_ns(); }
/// It stays as it is when no shot is under way.
std::int64_t stands_still(const RigFixture& bench, LineWatcher& watch) {
  const std::int64_t now = monotonic_now_ns();
  kill(bench.worker(), SIGSTOP);
  if (watch.state("SHUTTER").level != 0) return now;
  kill(bench.worker(), SIGCONT);
  return 0;
}
std::int64_t unplug(const RigFixture&, LineWatcher& watch) {
  const std::int64_t now = monotonic_now_ns();
  watch.unplug();
  return now;
}

const std::vector<Way>& ways() {
  static const std::vector<Way> all{
      {"worker, SIGTERM", Chip::keeps, to_worker(SIGTERM), ""},
      {"worker, SIGINT", Chip::keeps, to_worker(SIGINT), ""},
      {"worker, SIGSEGV", Chip::keeps, to_worker(SIGSEGV), "died of signal 11"},
      {"worker, abort", Chip::keeps, to_worker(SIGABRT), "died of signal 6"},
      {"worker, SIGKILL", Chip::keeps, to_worker(SIGKILL), "died of signal 9"},
      {"worker, SIGKILL, chip lets go", Chip::lets_go, to_worker(SIGKILL), "died of signal 9"},
      {"exception", Chip::keeps, dies, "died of signal 6", kAtOnce, "publisher-exception@1"},
      {"exception, chip lets go", Chip::lets_go, dies, "died of signal 6", kAtOnce, "publisher-exception@1"},
      {"guardian, SIGTERM", Chip::keeps, to_guardian(SIGTERM), ""},
      {"guardian, SIGINT", Chip::keeps, to_guardian(SIGINT), ""},
      {"guardian, SIGKILL", Chip::keeps, to_guardian(SIGKILL), "stopped: the guardian died"},
      {"guardian, SIGKILL, chip lets go", Chip::lets_go, to_guardian(SIGKILL), "stopped: the guardian died"},
      {"both, SIGQUIT", Chip::keeps, to_both(SIGQUIT), ""},
      {"both, SIGUSR1", Chip::keeps, to_both(SIGUSR1), ""},
      {"both, last real-time signal", Chip::keeps, to_both(SIGRTMAX), ""},
      {"both, SIGSEGV", Chip::keeps, to_both(SIGSEGV), "died of signal 11"},
      {"both, SIGKILL, then --safe", Chip::keeps, kill_both, "", 2000 * kMs},
      {"both, SIGKILL, chip lets go, then --safe", Chip::lets_go, kill_both, "", 2000 * kMs},
      {"loop hangs", Chip::keeps, hangs, "the loop hung and the worker was killed", hang_known_within(),
       "loop-hang@1"},
      {"worker hangs, chip lets go", Chip::lets_go, stands_still,
       "the loop hung and the worker was killed", hang_known_within()},
      // The loop turns at the next flash, after 5 ms; the one after that fails.
      {"an output fails", Chip::keeps, hangs, "an output could not be switched off; the guardian made",
       kAtOnce + 10 * kMs, "output-failure@1"},
      {"chip unplugged", Chip::keeps, unplug, "THE OUTPUTS MAY BE ACTIVE", kAtOnce, "", true},
      {"chip unplugged, lets go", Chip::lets_go, unplug, "an output could not be switched off"},
  };
  return all;
}

void expect_whole_journal(const RigFixture& bench, const char* way) {
  const LogContents journal = read_log(bench.journal());
  CHECK_TEXT(!journal.events.empty(), way);
  std::int64_t expected = 1;
  for (const auto& event : journal.events) {
    LONGS_EQUAL_TEXT(expected, event.sequence, way);
    ++expected;
  }
}

RigFixtureOptions options_of(const Way& way) {
  RigFixtureOptions options;
  options.rig_edits = {{"lag_ms = 310", "lag_ms = 70"}};  // shots that begin soon; nobody looks at the ball
  options.sim_options = kRealTime;
  if (way.chip == Chip::lets_go) options.scene_addition = "[chip]\non_release = \"input\"\n";
  if (*way.drill != '\0') options.strobed_options = {"--drill", way.drill};
  // What systemd does by ExecStopPost: the shell outlives both and runs --safe.
  if (way.safe_within_ns == 2000 * kMs) options.shell = "\"$@\"; \"$1\" --safe --config \"$3\"";
  return options;
}

/// Fires a shot and ends the process after its first flash; the instant of that.
std::int64_t do_in_mid_train(const RigFixture& bench, RawHost& host, const Way& way) {
  CHECK_TEXT(host.wait_status(), way.name);
  const auto shot = [&host](std::int64_t token) {
    strobe_msgs::command_t fire = host.fire_command(token, false);
    fire.plan.shutter_open_ns = 1'500 * kMs;  // longer than a hang is tolerated
    fire.plan.period_ns = 5 * kMs;
    fire.plan.impact_at_ns = 50 * kMs;
    return fire;
  };
  for (int attempt = 0; attempt < kFlashAttempts; ++attempt) {
    LineWatcher watch(bench.chip_dir());
    CHECK_TEXT(host.fire_until_flash(watch, shot, kFlashAttempts) != 0, way.name);
    // A machine that stood still may have aborted it since.
    if (*way.drill != '\0' || watch.state("SHUTTER").level != 0)
      if (const std::int64_t ended = way.end(bench, watch); ended != 0) return ended;
    const auto over = [&host] { return host.status().state == strobe_msgs::status_t::SPENT; };
    CHECK_TEXT(host.wait(over, kLongestWait), way.name);
  }
  FAIL(way.name);
  return 0;
}

double in_ms(std::int64_t ns) { return static_cast<double>(ns) * 1e-6; }

/// How much of that time no core, or not all of them, ran, as far as the witness saw.
std::int64_t stood_still(const std::vector<Freeze>& by_begin, std::int64_t from_ns, std::int64_t to_ns) {
  std::int64_t sum = 0, seen_to = from_ns;
  for (const Freeze& freeze : by_begin) {
    const std::int64_t begin = std::max(seen_to, strobe::to_ns(freeze.begin));
    const std::int64_t end = std::min(to_ns, strobe::to_ns(freeze.end));
    if (end <= begin) continue;
    sum += end - begin;
    seen_to = end;
  }
  return sum;
}

/// How many standstills that the witness may have missed explain when it was: 0 if it was in time, more than there may
/// be if it was later than one lasts.
int late_for(const Way& way, std::int64_t death, std::int64_t safe, const std::vector<Freeze>& freezes) {
  CHECK_TEXT(safe != INT64_MAX, way.name);
  const std::int64_t took = safe - death, still = stood_still(freezes, death, safe);
  std::printf("%s: outputs inactive after %.3f ms, in %.3f of which the machine stood still\n", way.name,
              in_ms(took), in_ms(still));
  if (took >= std::max(kSafeAtAllNs, way.safe_within_ns) || took - still > way.safe_within_ns + kUnseenNs)
    return kUnseen + 1;
  return took - still <= way.safe_within_ns ? 0 : 1;
}

/// As late_for().
int late_at_end(RigFixture& bench, const Way& way, std::int64_t death, const std::vector<Freeze>& freezes) {
  const LineChanges changes = bench.changes();
  for (const char* output : {"SHUTTER", "TRIGGER"})
    LONGS_EQUAL_TEXT(0, changes.rises(output, death), way.name);
  CHECK_TEXT(bench.log().find(way.said) != std::string::npos, (way.name + (":\n" + bench.log())).c_str());
  expect_whole_journal(bench, way.name);
  const std::int64_t safe = changes.outputs_safe_from(death);
  if (!way.stays_active) return late_for(way, death, safe, freezes);
  CHECK_TEXT(safe == INT64_MAX, way.name);
  return 0;
}

struct Trial {
  const Way* way;
  std::unique_ptr<RigFixture> bench;
  std::unique_ptr<RawHost> host;
  pid_t worker = 0;
  std::int64_t death = 0;
};

/// The worker may outlive its guardian, and the simulator with it, for as long as its last words take.
void wait_for_the_end(Trial& trial) {
  trial.bench->changes();
  const auto gone = [&trial] { return program_of(trial.worker).empty(); };
  CHECK_TEXT(wait_until(gone, kLongestWait), trial.way->name);
}

struct Lateness {
  int late = 0;
  bool frozen = false;  ///< the machine stood still too often to judge by
};

Lateness try_together(std::span<const Way> tried) {
  std::vector<Trial> trials;
  for (const Way& way : tried) {
    auto bench = std::make_unique<RigFixture>(options_of(way));
    auto host = std::make_unique<RawHost>(*bench);
    trials.push_back({&way, std::move(bench), std::move(host)});
  }
  for (Trial& trial : trials) {
    expect_ready(*trial.bench);
    trial.worker = trial.bench->worker();
  }
  FreezeDetector witness(kWitnessPriority);
  const std::int64_t begin_ns = monotonic_now_ns();
  for (Trial& trial : trials) trial.death = do_in_mid_train(*trial.bench, *trial.host, *trial.way);
  for (Trial& trial : trials) wait_for_the_end(trial);
  const std::vector<Freeze> freezes = witness.stop();
  Lateness all{0, stands_still_often(freezes, strobe::Duration{monotonic_now_ns() - begin_ns})};
  for (Trial& trial : trials) all.late += late_at_end(*trial.bench, *trial.way, trial.death, freezes);
  return all;
}

/// A guardian that stands still for good, while other benches are at work: nothing to see before 5 s are
/// over.
class StandingGuardian {
 public:
  StandingGuardian() : bench_(options()) {
    expect_ready(bench_);
    guardian_ = bench_.guardian();
    worker_ = bench_.worker();
    kill(guardian_, SIGSTOP);
  }
  void expect_that_the_worker_stopped() {
    CHECK(wait_until([&] { return program_of(worker_).empty(); }, kLongestWait));
    kill(guardian_, SIGCONT);
    bench_.changes();
    STRCMP_CONTAINS("stopped: the guardian hangs", bench_.log().c_str());
    expect_whole_journal(bench_, "guardian hangs");
  }

 private:
  static RigFixtureOptions options() {
    RigFixtureOptions options;
    options.sim_options = kRealTime;
    return options;
  }

  RigFixture bench_;
  pid_t guardian_ = 0, worker_ = 0;
};

}  // namespace

TEST_GROUP(Death){};

TEST(Death, LeavesTheOutputsInactiveHoweverItComes) {
  StandingGuardian standing;
  const std::span<const Way> all(ways());
  Lateness sum;
  for (std::size_t begin = 0; begin < all.size(); begin += kAtATime) {
    const Lateness some = try_together(all.subspan(begin, std::min(kAtATime, all.size() - begin)));
    sum = {sum.late + some.late, sum.frozen || some.frozen};
  }
  standing.expect_that_the_worker_stopped();
  if (sum.late > kUnseen && sum.frozen)
    return skip("the machine stood still too often to judge a millisecond by");
  CHECK_TEXT(sum.late <= kUnseen, std::to_string(sum.late).c_str());
}

TEST(Death, FollowsTheLossOfTheChipThoughNothingIsFired) {
  ReadyRig bench;
  const pid_t worker = bench.worker();
  LineWatcher(bench.chip_dir()).unplug();
  CHECK(wait_until([&] { return program_of(worker).empty(); }, kLongestWait));
  bench.changes();
  STRCMP_CONTAINS("stopped: an output could not be switched off", bench.log().c_str());
  expect_whole_journal(bench, "no chip");
}

TEST(Death, OfAPublisherThatHangsIsOrderlyAndTheServiceManagerHearsOfIt) {
  TemporaryFolder folder;
  FakeServiceManager manager((folder / "notify").string());
  RigFixtureOptions options;
  options.environment = {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "2000000"}};
  options.strobed_options = {"--drill", "publisher-hang@1"};
  ReadyRig bench(options);
  CHECK(wait_until([&] { return manager.count("READY=1") == 1; }, kLongestWait));
  RawHost host(bench);
  do_in_mid_train(bench, host, {"publisher hangs", Chip::keeps, hangs, ""});
  const LineChanges changes = bench.changes();
  CHECK(changes.outputs_safe_from(0) != INT64_MAX);
  CHECK(bench.log().find("the publisher hung and the worker was stopped") != std::string::npos);
  CHECK(manager.count("WATCHDOG=1") >= 2);
  CHECK_EQUAL(1, manager.count("STATUS=the publisher hung"));
  expect_whole_journal(bench, "publisher hangs");
}

TEST(Death, DoesNotBefallAWorkerThatStandsStillWhileNoShotIsUnderWay) {
  TemporaryFolder folder;
  FakeServiceManager manager((folder / "notify").string());
  RigFixtureOptions options;
  options.environment = {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "2000000"}};
  options.sim_options = kRealTime;  // rig time waits for a loop that stands still
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  const auto hears = [&manager](const char* words) {
    return wait_until([&] { return manager.count(words) > 0; }, kLongestWait);
  };
  CHECK(hears("READY=1"));
  const pid_t worker = bench.worker();
  kill(worker, SIGSTOP);
  CHECK(hears("STATUS=the loop stands still"));  // which may have been a machine that stood still
  const auto no_beat_comes = [&] {
    const int before = manager.count("WATCHDOG=1");
    host.listen(1200ms);  // more than twice the time between two beats
    return before == manager.count("WATCHDOG=1");
  };
  CHECK(wait_until(no_beat_comes, kLongestWait));
  const int beats = manager.count("WATCHDOG=1");
  kill(worker, SIGCONT);
  CHECK_TEXT(hears("STATUS=ready"), bench.log().c_str());
  const auto beats_again = [&] { return manager.count("WATCHDOG=1") > beats; };
  CHECK_TEXT(wait_until(beats_again, kLongestWait), bench.log().c_str());
  bench.finish();
  for (const char* said :
       {"the loop stands still, no shot is under way: waiting for it", "the loop turns again after"})
    STRCMP_CONTAINS(said, bench.log().c_str());
  CHECK(bench.log().find("hung") == std::string::npos);
}

TEST(Death, OfNobodyIsTheEndOfStandardErrorOrOfTheNetwork) {
  // head ends after strobed's first lines, so that the next one finds nobody; the route takes LCM away.
  RigFixtureOptions options;
  options.shell = "\"$@\" 2>&1 | head -n 1 >&2";
  RigFixture bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  LineWatcher watch(bench.chip_dir());
  const auto shot_of = [&host](std::int64_t token) { return host.fire_command(token, false); };
  CHECK(host.fire_until_flash(watch, shot_of, kFlashAttempts) != 0);
  const Command no_route{{"ip", "route", "del", "224.0.0.0/4", "dev", "lo"}, {}, {}, {}};
  const Command route{{"ip", "route", "add", "224.0.0.0/4", "dev", "lo"}, {}, {}, {}};
  const bool cut = run_process(no_route, kLongestWait).status == ExitStatus({0, 0});
  const bool closed = watch.wait_for("SHUTTER", 0, kLongestWait) != 0;
  if (cut) run_process(route, kLongestWait);  // the next tests need it, too
  CHECK(closed);
  CHECK(host.wait([&] { return host.status().state == strobe_msgs::status_t::SPENT; }, kLongestWait));
  const std::int32_t shot = host.status().last_shot_id;
  const std::int64_t token = host.arm();
  CHECK(token != 0);
  host.send(host.fire_command(token, false));
  CHECK_TEXT(host.wait([&] { return host.status().last_shot_id == shot + 1; }, kLongestWait),
             host.status().message.c_str());
  CHECK(host.wait([&] { return !host.shots().empty() && host.shots().back().shot_id == shot + 1; },
                  kLongestWait));
  bench.finish();
  expect_whole_journal(bench, "no network");
  LONGS_EQUAL(shot + 1, read_log(bench.journal()).shots.size());
}
