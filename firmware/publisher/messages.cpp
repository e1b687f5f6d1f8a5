#include "firmware/publisher/messages.hpp"

#include <algorithm>
#include <ctime>
#include <limits>

#include "common/messages/plan_lcm.hpp"

namespace strobe::firmware {

static_assert(static_cast<int>(EventKind::started) == strobe_msgs::event_t::STARTED);
static_assert(static_cast<int>(EventKind::flash) == strobe_msgs::event_t::FLASH);
static_assert(static_cast<int>(EventKind::cleared) == strobe_msgs::event_t::CLEARED);
static_assert(static_cast<int>(EventKind::repaired) == strobe_msgs::event_t::REPAIRED);
static_assert(static_cast<int>(EventKind::reset) == strobe_msgs::event_t::RESET);
static_assert(static_cast<int>(EventKind::xsync) == strobe_msgs::event_t::XSYNC);
static_assert(static_cast<int>(Line::xsync) == strobe_msgs::event_t::LINE_XSYNC);
static_assert(static_cast<int>(ShutterFeedback::late) == strobe_msgs::shot_t::FEEDBACK_LATE);
static_assert(static_cast<int>(Line::strobe_a) == strobe_msgs::event_t::LINE_STROBE_A);
static_assert(static_cast<int>(Line::estop) == strobe_msgs::event_t::LINE_ESTOP);
static_assert(strobe_msgs::event_t::NO_TIME == to_ns(kNoTime));

strobe_msgs::event_t to_message(const Event& event, std::int64_t boot_id, std::int64_t sequence) {
  strobe_msgs::event_t message{};
  message.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  message.boot_id = boot_id;
  message.sequence = sequence;
  message.kind = static_cast<std::int8_t>(event.kind);
  message.shot_id = event.shot_id;
  message.device_time_ns = to_ns(event.device_time);
  message.commanded_ns = to_ns(event.commanded);
  message.issue_start_ns = to_ns(event.issue_start);
  message.issue_end_ns = to_ns(event.issue_end);
  message.flash_index = event.flash_index;
  message.line = static_cast<std::int8_t>(event.line);
  message.level = event.level;
  message.detail = event.detail.view();
  return message;
}

std::vector<Note> merged(const std::vector<Note>& rig_record, const std::vector<Note>& command) {
  std::vector<Note> notes = rig_record;
  for (const Note& note : command) {
    const auto same =
        std::find_if(notes.begin(), notes.end(), [&](const Note& n) { return n.key == note.key; });
    if (same == notes.end()) {
      notes.push_back(note);
    } else {
      same->value = note.value;
    }
  }
  return notes;
}

namespace {

std::vector<strobe_msgs::flash_t> flashes_of(const ShotRecord& record) {
  std::vector<strobe_msgs::flash_t> flashes;
  flashes.reserve(record.flashes.size());
  for (const FlashRecord& flash : record.flashes) {
    strobe_msgs::flash_t message{};
    message.flash_index = static_cast<std::int32_t>(flashes.size());
    message.lamps = static_cast<std::int8_t>(flash.lamps);
    message.commanded_ns = to_ns(flash.commanded);
    message.issue_start_ns = to_ns(flash.issue_start);
    message.issue_end_ns = to_ns(flash.issue_end);
    message.observed_a_ns = to_ns(flash.observed_a);
    message.observed_b_ns = to_ns(flash.observed_b);
    message.extra_edges = flash.extra_edges;
    flashes.push_back(message);
  }
  return flashes;
}

}  // namespace

strobe_msgs::shot_t to_message(const ShotRecord& record, const Rig& rig, std::int64_t boot_id,
                               SequenceRange sequences, const std::vector<Note>& notes) {
  strobe_msgs::shot_t message{};
  message.schema_version = strobe_msgs::shot_t::SCHEMA_VERSION;
  message.boot_id = boot_id;
  message.shot_id = record.shot_id;
  message.host_id = record.host_id;
  message.first_sequence = sequences.first;
  message.last_sequence = sequences.last;
  message.plan = messages::plan_to_lcm(record.plan);
  message.start_ns = to_ns(record.start);
  message.shutter_on_ns = to_ns(record.shutter_on);
  message.shutter_off_ns = to_ns(record.shutter_off);
  message.shutter_feedback = static_cast<std::int8_t>(record.shutter_feedback);
  message.shutter_open_ns = to_ns(record.shutter_open);
  message.shutter_close_ns = to_ns(record.shutter_close);
  message.trigger_ns = to_ns(record.trigger);
  message.gate_ns = to_ns(record.gate);
  message.lamp_delay_a_us = rig.lamps.delay_a_us;
  message.lamp_delay_b_us = rig.lamps.delay_b_us;
  message.sensor_a_fitted = rig.line(Line::sensor_a).fitted;
  message.sensor_b_fitted = rig.line(Line::sensor_b).fitted;
  message.late_tolerance_us = static_cast<double>(rig.tolerance.late.count()) / 1e3;
  message.queue_overflows = record.queue_overflows;
  message.kernel_overflows = record.kernel_overflows;
  message.aborted = !record.abort_reason.empty();
  message.abort_reason = record.abort_reason.view();
  message.flashes = flashes_of(record);
  message.flash_count = static_cast<std::int32_t>(message.flashes.size());
  for (const Note& note : notes) {
    message.notes.emplace_back();
    message.notes.back().key = note.key;
    message.notes.back().value = note.value;
  }
  message.note_count = static_cast<std::int32_t>(message.notes.size());
  return message;
}

namespace {

using authentication::Rejection;
using strobe_msgs::histogram_t;
using strobe_msgs::status_t;

static_assert(static_cast<int>(State::idle) == status_t::IDLE);
static_assert(static_cast<int>(State::fault) == status_t::FAULT);
static_assert(static_cast<int>(State::spent) == status_t::SPENT);
static_assert(static_cast<int>(State::stopped) == status_t::STOPPED);
static_assert(static_cast<int>(TimingQuantity::lateness) == histogram_t::LATENESS);
static_assert(static_cast<int>(TimingQuantity::period_error) == histogram_t::PERIOD_ERROR);

constexpr Duration kTogether = microseconds(20);
constexpr int kTries = 4;

std::int64_t system_ns(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

double us(double ns) { return ns * 1e-3; }
double us(Duration d) { return us(static_cast<double>(d.count())); }

/// Why it cannot be armed or fired now.
std::string lacking(const StatusParts& parts) {
  const LoopStatus& loop = parts.loop;
  if (!loop.fault.empty()) return "fault: " + std::string(loop.fault);
  if (!parts.journal_fault.empty()) return "the journal cannot be written: " + parts.journal_fault;
  if (loop.estop_active) return "the e-stop is pressed, or its wire is broken";
  if (!loop.key_active) return "the key is off, or its wire is broken";
  if (!loop.stop.empty())
    return "stopped (" + std::string(loop.stop) + "): a person must give the command to fire anew";
  if (parts.clocks.mono < loop.restart) return "a stop was reset just now: the rig can be armed in a moment";
  return "";
}

void put_loop(status_t& message, const LoopStatus& loop) {
  message.state = static_cast<std::int8_t>(loop.state);
  message.key_active = loop.key_active;
  message.estop_active = loop.estop_active;
  message.arm_host_id = loop.arm_host;
  message.arm_token = loop.arm_token;
  message.arm_expires_ns = to_ns(loop.arm_expires);
  message.last_shot_id = loop.last_shot_id;
  message.kernel_overflows = loop.kernel_overflows;
}

void put_rejected(status_t& message, const RejectedCommands& rejected) {
  message.rejected_malformed = rejected[Rejection::malformed];
  message.rejected_oversized = rejected[Rejection::oversized];
  message.rejected_forged = rejected[Rejection::forged];
  message.rejected_replayed = rejected[Rejection::replayed];
  message.rejected_stale = rejected[Rejection::stale];
  message.rejected_other_rig = rejected[Rejection::other_rig];
}

void put_earlier(status_t& message, const std::vector<EarlierBoot>& earlier) {
  constexpr std::size_t kMax = 16;
  for (std::size_t i = 0; i < std::min(kMax, earlier.size()); ++i) {
    message.earlier.emplace_back();
    message.earlier.back().boot_id = earlier[i].boot_id;
    message.earlier.back().last_sequence = earlier[i].last_sequence;
  }
  message.earlier_count = static_cast<std::int32_t>(message.earlier.size());
}

}  // namespace

std::int64_t system_wall_ns() { return system_ns(CLOCK_REALTIME); }
std::int64_t system_boot_time_ns() { return system_ns(CLOCK_BOOTTIME); }

ClockReading read_clocks(Clock& clock, const std::function<std::int64_t()>& wall_ns,
                         const std::function<std::int64_t()>& boot_time_ns) {
  ClockReading best;
  Duration closest{std::numeric_limits<std::int64_t>::max()};
  for (int i = 0; i < kTries && closest > kTogether; ++i) {
    const MonoTime before = clock.now();
    ClockReading reading{before, wall_ns(), boot_time_ns()};
    const Duration apart = clock.now() - before;
    reading.mono = before + apart / 2;
    if (apart < closest) best = reading;
    closest = std::min(closest, apart);
  }
  return best;
}

histogram_t to_message(TimingQuantity quantity, const TimingHistogram& histogram) {
  const bool any = histogram.count() > 0;
  const auto value = [any](double number) { return any ? number : std::numeric_limits<double>::quiet_NaN(); };
  histogram_t message{};
  message.quantity = static_cast<std::int8_t>(quantity);
  message.count = histogram.count();
  message.mean_us = value(us(histogram.mean_ns()));
  message.sd_us = value(us(histogram.sd_ns()));
  message.min_us = value(us(histogram.min()));
  message.p50_us = value(us(histogram.percentile(0.5)));
  message.p99_us = value(us(histogram.percentile(0.99)));
  message.p999_us = value(us(histogram.percentile(0.999)));
  message.max_us = value(us(histogram.max()));
  const TimingHistogram::Coarse coarse = histogram.coarse();
  message.bin_first_us = value(us(coarse.first));
  message.bin_width_us = value(us(coarse.width));
  message.bin_count = static_cast<std::int32_t>(coarse.count);
  message.bins.assign(coarse.bins.begin(), coarse.bins.begin() + message.bin_count);
  return message;
}

const histogram_t& HistogramMessages::of(TimingQuantity quantity, const TimingHistogram& histogram) {
  const auto last = last_.find(quantity);
  if (last != last_.end() && last->second.count == histogram.count()) return last->second;
  return last_.insert_or_assign(quantity, to_message(quantity, histogram)).first->second;
}

status_t to_message(const StatusParts& parts, const ShotTiming& timing, HistogramMessages& histograms) {
  status_t message{};
  message.schema_version = status_t::SCHEMA_VERSION;
  message.boot_id = parts.boot_id;
  message.last_sequence = parts.last_sequence;
  message.mono_ns = to_ns(parts.clocks.mono);
  message.wall_ns = parts.clocks.wall_ns;
  message.boot_time_ns = parts.clocks.boot_time_ns;
  put_loop(message, parts.loop);
  message.real_time = parts.real_time;
  message.journal_ok = parts.journal_fault.empty();
  message.queue_overflows = parts.queue_overflows;
  put_rejected(message, parts.rejected);
  put_earlier(message, parts.earlier);
  for (const TimingQuantity quantity : kTimingQuantities)
    message.histograms.push_back(histograms.of(quantity, timing.of(quantity)));
  message.histogram_count = static_cast<std::int32_t>(message.histograms.size());
  message.message = lacking(parts);
  return message;
}

}  // namespace strobe::firmware
