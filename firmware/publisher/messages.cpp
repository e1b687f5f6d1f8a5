#include "firmware/publisher/messages.hpp"

#include <algorithm>

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

}  // namespace strobe::firmware
