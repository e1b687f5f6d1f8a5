// The loop's records to LCM messages. Pure; allocate; thread-safe.
#pragma once

#include <cstdint>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/plan_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/shot/sequence_range.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

strobe_msgs::event_t to_message(const Event& event, std::int64_t boot_id, std::int64_t sequence);
strobe_msgs::plan_t to_message(const PlanRequest& plan);
/// Of a code that is longer than CodedTrain can be, only the first part: to be refused before.
PlanRequest from_message(const strobe_msgs::plan_t& plan);

strobe_msgs::shot_t to_message(const ShotRecord& record, const Rig& rig, std::int64_t boot_id,
                               SequenceRange sequences, const std::vector<Note>& notes);

/// The rig file's entries, overridden by the command's of the same key, which come after them otherwise.
std::vector<Note> merged(const std::vector<Note>& rig_record, const std::vector<Note>& command);

}  // namespace strobe::firmware
