#include "common/messages/shot_versions.hpp"

namespace strobe::messages {
namespace {

strobe_msgs::plan_t plan_from_v1(const strobe_msgs::plan_v1_t& old) {
  strobe_msgs::plan_t plan{};
  plan.train = old.train;
  plan.period_ns = old.period_ns;
  plan.flash_count = old.flash_count;
  plan.shutter_open_ns = old.shutter_open_ns;
  plan.gate_delay_ns = old.gate_delay_ns;
  plan.impact_at_ns = old.impact_at_ns;
  plan.dry = old.dry;
  return plan;
}

strobe_msgs::flash_t flash_from_v1(const strobe_msgs::flash_v1_t& old) {
  strobe_msgs::flash_t flash{};
  flash.flash_index = old.flash_index;
  flash.lamps = strobe_msgs::coded_flash_t::BOTH_LAMPS;
  flash.commanded_ns = old.commanded_ns;
  flash.issue_start_ns = old.issue_start_ns;
  flash.issue_end_ns = old.issue_end_ns;
  flash.observed_a_ns = old.observed_a_ns;
  flash.observed_b_ns = old.observed_b_ns;
  flash.extra_edges = old.extra_edges;
  return flash;
}

}  // namespace

strobe_msgs::shot_t shot_from_v1(const strobe_msgs::shot_v1_t& old) {
  strobe_msgs::shot_t shot{};
  shot.schema_version = strobe_msgs::shot_t::SCHEMA_VERSION;
  shot.boot_id = old.boot_id;
  shot.shot_id = old.shot_id;
  shot.host_id = old.host_id;
  shot.first_sequence = old.first_sequence;
  shot.last_sequence = old.last_sequence;
  shot.plan = plan_from_v1(old.plan);
  shot.start_ns = old.start_ns;
  shot.shutter_on_ns = shot.shutter_off_ns = strobe_msgs::shot_t::NO_TIME;
  shot.shutter_open_ns = old.shutter_open_ns;
  shot.shutter_close_ns = old.shutter_close_ns;
  shot.shutter_feedback = strobe_msgs::shot_t::FEEDBACK_NONE;
  shot.trigger_ns = old.trigger_ns;
  shot.gate_ns = old.gate_ns;
  shot.lamp_delay_a_us = shot.lamp_delay_b_us = old.lamp_delay_us;
  shot.sensor_a_fitted = old.sensor_a_fitted;
  shot.sensor_b_fitted = old.sensor_b_fitted;
  shot.late_tolerance_us = old.late_tolerance_us;
  shot.queue_overflows = old.queue_overflows;
  shot.kernel_overflows = old.kernel_overflows;
  shot.aborted = old.aborted;
  shot.abort_reason = old.abort_reason;
  shot.flash_count = old.flash_count;
  shot.flashes.reserve(old.flashes.size());
  for (const auto& flash : old.flashes) shot.flashes.push_back(flash_from_v1(flash));
  shot.note_count = old.note_count;
  shot.notes = old.notes;
  return shot;
}

}  // namespace strobe::messages
