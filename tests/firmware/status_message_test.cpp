#include "firmware/publisher/status_message.hpp"

#include <cmath>
#include <memory>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

/// Each reading of it takes as long as the next entry says.
struct SteppingClock : Clock {
  MonoTime time = from_ns(1000);
  std::vector<Duration> steps;
  std::size_t next = 0;

  MonoTime now() noexcept override {
    const MonoTime result = time;
    if (next < steps.size()) time = time + steps[next++];
    return result;
  }
  MonoTime spin_until(MonoTime instant) noexcept override { return instant; }
};

}  // namespace

TEST_GROUP(StatusMessage) {
  std::unique_ptr<ShotTiming> timing = std::make_unique<ShotTiming>();
  StatusParts parts;
  HistogramMessages histograms;
};

TEST(StatusMessage, HasEveryQuantityFromTheStart) {
  const auto message = to_message(parts, *timing, histograms);
  CHECK_EQUAL(6, message.histogram_count);
  for (int k = 0; k < 6; ++k) {
    CHECK_EQUAL(k + 1, message.histograms[static_cast<std::size_t>(k)].quantity);
    CHECK_EQUAL(0, message.histograms[static_cast<std::size_t>(k)].count);
    CHECK_TRUE(std::isnan(message.histograms[static_cast<std::size_t>(k)].mean_us));
    CHECK_EQUAL(0, message.histograms[static_cast<std::size_t>(k)].bin_count);
  }
}

TEST(StatusMessage, TellsTimingInMicroseconds) {
  for (const std::int64_t late_ns : {100, 100, 400})
    timing->issued(MonoTime{}, from_ns(late_ns), from_ns(late_ns + 250));
  const auto message = to_message(parts, *timing, histograms);
  const auto& lateness = message.histograms[0];
  CHECK_EQUAL(3, lateness.count);
  DOUBLES_EQUAL(0.2, lateness.mean_us, 1e-12);
  DOUBLES_EQUAL(std::sqrt(0.02), lateness.sd_us, 1e-12);  // population: (0.1² + 0.1² + 0.2²)/3
  DOUBLES_EQUAL(0.1, lateness.p50_us, 1e-12);
  DOUBLES_EQUAL(0.1, lateness.min_us, 1e-12);
  DOUBLES_EQUAL(0.4, lateness.p99_us, 1e-12);
  DOUBLES_EQUAL(0.4, lateness.p999_us, 1e-12);
  DOUBLES_EQUAL(0.4, lateness.max_us, 1e-12);
  DOUBLES_EQUAL(0.1, lateness.bin_first_us, 1e-12);
  DOUBLES_EQUAL(0.02, lateness.bin_width_us, 1e-12);
  std::int64_t in_bins = 0;
  for (const std::int64_t n : lateness.bins) in_bins += n;
  CHECK_EQUAL(3, in_bins);
  DOUBLES_EQUAL(0.25, message.histograms[1].p99_us, 1e-12);
}

TEST(StatusMessage, TellsEveryValueThatCameSinceTheLast) {
  for (const std::int64_t late_ns : {100, 300, 200}) {
    timing->issued(MonoTime{}, from_ns(late_ns), from_ns(late_ns + 250));
    const auto made_now = to_message(TimingQuantity::lateness, timing->of(TimingQuantity::lateness));
    const auto message = to_message(parts, *timing, histograms).histograms[0];
    CHECK_EQUAL(made_now.count, message.count);
    DOUBLES_EQUAL(made_now.mean_us, message.mean_us, 0.0);
    DOUBLES_EQUAL(made_now.max_us, message.max_us, 0.0);
  }
}

TEST(StatusMessage, SaysThatAPersonMustResetAStopAndThatItWasJustReset) {
  parts.loop.estop_active = false;
  parts.loop.key_active = true;
  parts.loop.stop = "the e-stop was released";
  CHECK_EQUAL("stopped (the e-stop was released): a person must give the command to fire anew",
              to_message(parts, *timing, histograms).message);
  parts.loop.stop = "";
  parts.loop.restart = parts.clocks.mono + milliseconds(1);
  CHECK_EQUAL("a stop was reset just now: the rig can be armed in a moment",
              to_message(parts, *timing, histograms).message);
  parts.clocks.mono = parts.loop.restart;
  CHECK_EQUAL("", to_message(parts, *timing, histograms).message);
}

TEST(StatusMessage, SaysTheGravestThingThatIsMissing) {
  parts.loop.estop_active = false;
  CHECK_EQUAL("the key is off, or its wire is broken", to_message(parts, *timing, histograms).message);
  parts.loop.estop_active = true;
  CHECK_EQUAL("the e-stop is pressed, or its wire is broken", to_message(parts, *timing, histograms).message);
  parts.journal_fault = "the disk is full";
  CHECK_EQUAL("the journal cannot be written: the disk is full",
              to_message(parts, *timing, histograms).message);
  CHECK_FALSE(to_message(parts, *timing, histograms).journal_ok);
  parts.loop.fault = "broken";
  CHECK_EQUAL("fault: broken", to_message(parts, *timing, histograms).message);
}

TEST(StatusMessage, TellsAllOfTheLoopAndTheClocks) {
  parts = {1,  2,  {from_ns(3), 4, 5}, {State::armed, true, false, 6, 7, from_ns(8), 9, 10, "", "", {}}, true, "",
           11, {}, {{12, 13}}};
  const auto message = to_message(parts, *timing, histograms);
  CHECK_EQUAL(+strobe_msgs::status_t::SCHEMA_VERSION, message.schema_version);
  CHECK(message.boot_id == 1 && message.last_sequence == 2);
  CHECK(message.mono_ns == 3 && message.wall_ns == 4 && message.boot_time_ns == 5);
  CHECK_EQUAL(+strobe_msgs::status_t::ARMED, message.state);
  CHECK(message.key_active && !message.estop_active && message.real_time && message.journal_ok);
  CHECK(message.arm_host_id == 6 && message.arm_token == 7 && message.arm_expires_ns == 8);
  CHECK(message.last_shot_id == 9 && message.kernel_overflows == 10 && message.queue_overflows == 11);
  CHECK_EQUAL(1, message.earlier_count);
  CHECK(message.earlier.at(0).boot_id == 12 && message.earlier.at(0).last_sequence == 13);
  CHECK_FALSE(to_message(StatusParts{}, *timing, histograms).real_time);
}

TEST(StatusMessage, CountsWhatWasIgnored) {
  parts.rejected = {1, 2, 3, 4, 5, 6};
  const auto message = to_message(parts, *timing, histograms);
  CHECK_EQUAL(1, message.rejected_malformed);
  CHECK_EQUAL(2, message.rejected_oversized);
  CHECK_EQUAL(3, message.rejected_forged);
  CHECK_EQUAL(4, message.rejected_replayed);
  CHECK_EQUAL(5, message.rejected_stale);
  CHECK_EQUAL(6, message.rejected_other_rig);
}

TEST(StatusMessage, ReadsTheClocksAgainWhenItWasHeldUpBetweenThem) {
  SteppingClock clock;
  clock.steps = {milliseconds(30), microseconds(1), microseconds(4), microseconds(1)};
  std::int64_t wall_ns = 0;
  const auto reading = read_clocks(
      clock, [&] { return ++wall_ns; }, [] { return std::int64_t{77}; });
  CHECK_EQUAL(2, reading.wall_ns);
  CHECK_EQUAL(77, reading.boot_time_ns);
  // Read first at 1000 ns, then after 30 ms and 1 us, with 4 us from one reading to the next.
  CHECK_EQUAL(1000 + 30'001'000 + 2000, to_ns(reading.mono));
}

TEST(StatusMessage, TakesTheClosestReadingIfNoneIsClose) {
  SteppingClock clock;
  clock.steps.assign(8, milliseconds(5));
  clock.steps[4] = milliseconds(2);
  std::int64_t wall_ns = 0;
  const auto reading = read_clocks(
      clock, [&] { return ++wall_ns; }, [] { return std::int64_t{0}; });
  CHECK_EQUAL(4, wall_ns);
  CHECK_EQUAL(3, reading.wall_ns);
}
