#include <cmath>
#include <memory>

#include "firmware/publisher/messages.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(FirmwareMessages){};

TEST(FirmwareMessages, TellAllOfAnEvent) {
  Event event;
  event.kind = EventKind::estop;
  event.line = Line::estop;
  event.level = 1;
  event.shot_id = 3;
  event.flash_index = 4;
  event.device_time = from_ns(5);
  event.commanded = from_ns(6);
  event.issue_start = from_ns(7);
  event.issue_end = from_ns(8);
  event.detail = "words";
  const auto message = to_message(event, 9, 10);
  CHECK_EQUAL(+strobe_msgs::event_t::SCHEMA_VERSION, message.schema_version);
  CHECK_EQUAL(+strobe_msgs::event_t::ESTOP, message.kind);
  CHECK_EQUAL(+strobe_msgs::event_t::LINE_ESTOP, message.line);
  CHECK_EQUAL(1, message.level);
  CHECK_EQUAL(3, message.shot_id);
  CHECK_EQUAL(4, message.flash_index);
  CHECK_EQUAL(5, message.device_time_ns);
  CHECK_EQUAL(6, message.commanded_ns);
  CHECK_EQUAL(7, message.issue_start_ns);
  CHECK_EQUAL(8, message.issue_end_ns);
  CHECK_EQUAL(9, message.boot_id);
  CHECK_EQUAL(10, message.sequence);
  CHECK_EQUAL(std::string("words"), message.detail);
}

TEST(FirmwareMessages, TellAllOfAShot) {
  ShotRecord record;
  record.shot_id = 1;
  record.host_id = 2;
  record.plan.period = nanoseconds(3);
  record.start = from_ns(4);
  record.shutter_open = from_ns(5);
  record.shutter_close = from_ns(6);
  record.trigger = from_ns(7);
  record.gate = from_ns(8);
  record.queue_overflows = 9;
  record.kernel_overflows = 10;
  record.abort_reason = "why";
  record.flashes.resize(1);
  record.flashes[0] = {Lamps::a, from_ns(11), from_ns(12), from_ns(13), from_ns(14), from_ns(15), 16};
  Rig rig;
  rig.line(Line::sensor_b).fitted = true;
  rig.tolerance.late = microseconds(17);
  const auto shot = to_message(record, rig, 18, {19, 20}, {{"key", "value"}});
  CHECK_EQUAL(+strobe_msgs::shot_t::SCHEMA_VERSION, shot.schema_version);
  CHECK(shot.shot_id == 1 && shot.host_id == 2 && shot.plan.period_ns == 3 && shot.start_ns == 4);
  CHECK(shot.shutter_open_ns == 5 && shot.shutter_close_ns == 6 && shot.trigger_ns == 7 && shot.gate_ns == 8);
  CHECK(shot.queue_overflows == 9 && shot.kernel_overflows == 10);
  CHECK_TRUE(shot.aborted);
  CHECK_EQUAL(std::string("why"), shot.abort_reason);
  const auto& flash = shot.flashes.at(0);
  CHECK(flash.commanded_ns == 11 && flash.issue_start_ns == 12 && flash.issue_end_ns == 13);
  CHECK(flash.observed_a_ns == 14 && flash.observed_b_ns == 15 && flash.extra_edges == 16);
  CHECK(!shot.sensor_a_fitted && shot.sensor_b_fitted);
  DOUBLES_EQUAL(17.0, shot.late_tolerance_us, 0.0);
  CHECK(shot.boot_id == 18 && shot.first_sequence == 19 && shot.last_sequence == 20);
  CHECK_EQUAL(1, shot.note_count);
  CHECK_EQUAL(std::string("key"), shot.notes.at(0).key);
  CHECK_EQUAL(std::string("value"), shot.notes.at(0).value);
}

TEST(FirmwareMessages, TellEachFlashsLampsAndTheShutter) {
  ShotRecord record;
  record.flashes.resize(2);
  record.flashes[1].lamps = Lamps::b;
  record.shutter_on = from_ns(7);
  record.shutter_off = from_ns(8);
  record.shutter_feedback = ShutterFeedback::late;
  Rig rig;
  rig.lamps.delay_b_us = 13.5;
  const auto shot = to_message(record, rig, 7, {1, 9}, {});
  CHECK_EQUAL(3, shot.flashes[0].lamps);
  CHECK_EQUAL(2, shot.flashes[1].lamps);
  CHECK_EQUAL(7, shot.shutter_on_ns);
  CHECK_EQUAL(8, shot.shutter_off_ns);
  CHECK_EQUAL(+strobe_msgs::shot_t::FEEDBACK_LATE, shot.shutter_feedback);
  DOUBLES_EQUAL(12.0, shot.lamp_delay_a_us, 0.0);
  DOUBLES_EQUAL(13.5, shot.lamp_delay_b_us, 0.0);
}

TEST(FirmwareMessages, SayWhatWasNotSeen) {
  ShotRecord record;
  record.flashes.resize(2);
  record.flashes[1].observed_a = from_ns(123);
  const auto shot = to_message(record, Rig(), 7, {1, 9}, {});
  CHECK_EQUAL(2, shot.flash_count);
  CHECK_EQUAL(1, shot.flashes[1].flash_index);
  CHECK_EQUAL(123, shot.flashes[1].observed_a_ns);
  CHECK_EQUAL(strobe_msgs::flash_t::NO_TIME, shot.flashes[1].observed_b_ns);
  CHECK_EQUAL(strobe_msgs::flash_t::NO_TIME, shot.flashes[0].issue_end_ns);
  CHECK_EQUAL(+strobe_msgs::shot_t::NO_TIME, shot.trigger_ns);
  CHECK_EQUAL(+strobe_msgs::shot_t::NO_TIME, shot.gate_ns);
  CHECK_FALSE(shot.aborted);
  CHECK_FALSE(shot.sensor_a_fitted);
}

TEST(FirmwareMessages, PutACommandsNotesOverTheRigFiles) {
  const auto notes = merged({{"operator", ""}, {"ball_name", "new"}}, {{"operator", "M"}, {"spin", "zero"}});
  CHECK_EQUAL(3u, notes.size());
  CHECK_EQUAL(std::string("M"), notes[0].value);
  CHECK_EQUAL(std::string("new"), notes[1].value);
  CHECK_EQUAL(std::string("spin"), notes[2].key);
}

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
