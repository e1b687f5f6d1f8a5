// The shipped programs with a flash sequencer in place of the chip: shots are measured as with it, and whatever becomes of
// strobed, the cable or the sequencer itself in the middle of a train, every output is inactive within 20 ms and stays so.
// What the rig's lines did is the judge.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

constexpr std::int64_t kSafeWithin = 20 * kMs;
/// By the sequencer's pins themselves.
constexpr std::int64_t kAtOnce = kMs;

/// Once settled, of what is told. A request leaves at once, a reply is heard by a loop that takes 10 to 70 us, mostly below
/// 18, to wake up.
constexpr double kKnownWithin_us = 1.0;
/// Told or played, before that as well: half of those 10 us, and as much for what is not known of the drift yet.
constexpr double kAtFirstWithin_us = 10.0;
/// The clocks' relation takes four seconds to settle, a shot one and more.
constexpr std::size_t kSettled = 4;

RigFixtureOptions on_sequencer() {
  RigFixtureOptions options;
  options.sequencer = true;
  return options;
}

using Victim = pid_t (RigFixture::*)() const;

struct Trouble {
  const char* name;
  std::string line;  ///< driven to 0; empty: none
  std::int64_t safe_within_ns;
  const char* said = nullptr;  ///< in the reason of the shot's abort; null: nobody is left to say it
  bool mends = false;          ///< the line goes back after 30 ms
  std::vector<Victim> victims{};
  int signal = 0;
};

const std::vector<Trouble>& troubles() {
  const std::vector<Victim> worker{&RigFixture::worker}, both{&RigFixture::guardian, &RigFixture::worker};
  static const std::vector<Trouble> all{
      {"e-stop", "ESTOP", kAtOnce, "e-stop"},
      {"key off", "KEY", kAtOnce, "key"},
      {"key off and on", "KEY", kAtOnce, "key", true},
      {"cable pulled", "SEQUENCER_CABLE", kSafeWithin, "the flash sequencer does not answer"},
      {"cable pulled and plugged in again", "SEQUENCER_CABLE", kSafeWithin, "the flash sequencer", true},
      {"held in reset", "SEQUENCER_RUN", kAtOnce, "the flash sequencer does not answer"},
      {"brown-out", "SEQUENCER_RUN", kAtOnce, "the flash sequencer was reset", true},
      {"worker killed", "", kSafeWithin, nullptr, false, worker, SIGKILL},
      {"both killed", "", kSafeWithin, nullptr, false, both, SIGKILL},
      {"both stopped", "", kSafeWithin, nullptr, false, both, SIGSTOP},
  };
  return all;
}

void send(const RigFixture& bench, const std::vector<Victim>& victims, int signal) {
  std::vector<pid_t> pids;
  for (const Victim victim : victims) pids.push_back((bench.*victim)());
  for (const pid_t pid : pids)
    if (pid != 0) kill(pid, signal);
}

}  // namespace

TEST_GROUP(FlashSequencer){};

namespace {

/// How far flashes were told, or played, from the truth. [us]
struct Offsets {
  double farthest = 0.0;         ///< of all
  double mean = 0.0, rms = 0.0;  ///< of what was told once the clocks' relation had settled; rms about the mean
};

Offsets offsets_of_nine_shots(const RigFixtureOptions& options) {
  ReadyRig bench(options);
  const auto fired = ran(bench.fire(9, 0));
  LONGS_EQUAL(9, readouts(fired.out).size());
  const LogContents journal = read_log(bench.journal());
  const LineChanges changes = bench.finish();
  LONGS_EQUAL(9, journal.shots.size());
  std::vector<std::int64_t> rises;
  for (const LineChange& change : changes.all())
    if (change.line == "STROBE_A" && change.level == 1) rises.push_back(change.time_ns);
  std::size_t flash = 0, counted = 0;
  double sum = 0.0, squares = 0.0;
  Offsets offsets;
  for (std::size_t i = 0; i < journal.shots.size(); ++i) {
    CHECK_FALSE(journal.shots[i].aborted);
    for (const auto& each : journal.shots[i].flashes) {
      CHECK(flash < rises.size());
      const double off = 1e-3 * static_cast<double>(each.issue_end_ns - rises[flash]);
      offsets.farthest = std::max({offsets.farthest, std::abs(off),
                                   1e-3 * static_cast<double>(std::abs(rises[flash] - each.commanded_ns))});
      ++flash;
      if (i < kSettled) continue;
      sum += off;
      squares += off * off;
      ++counted;
    }
  }
  LONGS_EQUAL(rises.size(), flash);
  offsets.mean = sum / static_cast<double>(counted);
  offsets.rms = std::sqrt(squares / static_cast<double>(counted) - offsets.mean * offsets.mean);
  std::printf("%zu flashes: told or played %.3f us off at most; told %.3f us off in the mean, rms about it %.3f us\n", flash,
              offsets.farthest, offsets.mean, offsets.rms);
  return offsets;
}

}  // namespace

TEST(FlashSequencer, ShotsAreMeasuredAndTheirFlashesKnownToTheMicrosecond) {
  RigFixtureOptions options = on_sequencer();
  options.sim_options = kFastTime;
  const Offsets offsets = offsets_of_nine_shots(options);
  CHECK(offsets.farthest < kAtFirstWithin_us);
  CHECK(std::hypot(offsets.mean, offsets.rms) < kKnownWithin_us);
}

// Of the simulated chip's stamps none is late: what is left is how the relation by the line alone changed from one shot
// to the next.
TEST(FlashSequencer, FlashesThatTheKernelStampsTooAreKnownToTheMicrosecond) {
  RigFixtureOptions options = on_sequencer();
  options.sim_options = kFastTime;
  options.rig_edits = {{"[lamps]",
                        "[chip]\nname = \"gpiochip0\"\n\n[lines]\nsensor_a = { line = \"SENSOR_A\" }\n"
                        "sensor_b = { line = \"SENSOR_B\" }\n\n[lamps]"}};
  const Offsets offsets = offsets_of_nine_shots(options);
  CHECK(std::hypot(offsets.mean, offsets.rms) < kKnownWithin_us);
}

// The gate's edge is stamped, and the burst counted from it, in steps of 8 ns by a clock whose drift is known better than
// the 30 ppm, 60 ns of 2 ms, that it may have.
TEST(FlashSequencer, AGatedBurstBeginsItsDelayAfterTheGate) {
  RigFixtureOptions options = on_sequencer();
  options.sim_options = kFastTime;
  options.rig_edits = {{"train = \"free\"", "train = \"gated\"\nflash_count = 60\ngate_delay_ms = 2.0"}};
  ReadyRig bench(options);
  ran(bench.fire(3, 10));
  const LineChanges changes = bench.finish();
  std::int64_t gate = 0;
  int bursts = 0;
  for (const LineChange& change : changes.all()) {
    if (change.line == "GATE" && change.level == 1) gate = change.time_ns;
    if (change.line != "STROBE_A" || change.level != 1 || gate == 0) continue;
    CHECK(std::abs(change.time_ns - gate - 2 * kMs) < 76);
    gate = 0;
    ++bursts;
  }
  CHECK(bursts >= 3);
}

TEST(FlashSequencer, ALineWithDamagedBytesAbortsNoShotAndWhatIsLostIsTold) {
  RigFixtureOptions options = on_sequencer();
  options.sim_options = kFastTime;
  ReadyRig bench(options);
  bench.drive("SEQUENCER_NOISE=1");
  // What is not told of flashes may leave open which made which image: then the shot is fired again.
  const auto fired = ran(bench.fire(5, 30));
  const LogContents journal = read_log(bench.journal());
  CHECK(journal.shots.size() >= 5);
  const auto read = readouts(fired.out);
  LONGS_EQUAL(journal.shots.size(), read.size());
  std::int64_t lost = 0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK_FALSE(journal.shots[i].aborted);
    CHECK_EQUAL(journal.shots[i].kernel_overflows > 0, has_flag(read[i], "events_missing"));
    lost += journal.shots[i].kernel_overflows;
  }
  CHECK(lost > 0);  // 3.5 of a shot's 350 edges of 20 bytes each
}

TEST(FlashSequencer, WhateverHappensInATrainOutputsAreInactiveWithinTwentyMillisecondsAndStaySo) {
  for (const Trouble& trouble : troubles()) {
    RigFixtureOptions options = on_sequencer();
    options.rig_edits = kShortExposure;
    ReadyRig bench(options);
    LineWatcher watch(bench.chip_dir());
    Process fire = bench.start(bench.fire(1, 0));
    CHECK_TEXT(watch.wait_for_nth("STROBE_A", 1, 20, 60s) != 0, (bench.log() + fire.err()).c_str());
    watch.hold_time();  // so that the stamp of what happens is the instant at which it does
    const std::int64_t happened = watch.now_ns();
    if (!trouble.line.empty()) watch.drive(trouble.line, 0);
    if (!trouble.victims.empty()) send(bench, trouble.victims, trouble.signal);
    watch.release_time();
    if (trouble.mends) {
      watch.wait_until([] { return false; }, 30ms);
      watch.drive(trouble.line, 1);
    }
    watch.wait_until([] { return false; }, 600ms);  // the train's rest, had it gone on, and what strobed says of it
    const LogContents journal = read_log(bench.journal());
    send(bench, {&RigFixture::guardian, &RigFixture::worker}, SIGCONT);
    const LineChanges changes = bench.finish();
    // By the stamp of what was done to a line.
    const auto done = std::ranges::find_if(changes.all(), [&](const LineChange& change) {
      return change.time_ns >= happened && change.cause == "drive" && trouble.line == change.line;
    });
    const std::int64_t from = done == changes.all().end() ? happened : done->time_ns;
    const std::int64_t safe = changes.outputs_safe_from(from);
    std::printf("%s: inactive after %.3f ms; %s\n", trouble.name, 1e-6 * static_cast<double>(safe - from),
                journal.shots.empty() ? "-" : journal.shots.back().abort_reason.c_str());
    CHECK_TEXT(safe - from <= trouble.safe_within_ns, trouble.name);
    if (trouble.said == nullptr) continue;
    CHECK_TEXT(!journal.shots.empty(), trouble.name);
    CHECK_TEXT(journal.shots.back().aborted, trouble.name);
    STRCMP_CONTAINS(trouble.said, journal.shots.back().abort_reason.c_str());
  }
}
