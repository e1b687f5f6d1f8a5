// From the loop's records to LCM messages. Pure; they allocate; thread-safe.
#pragma once

#include <cstdint>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/shot/sequence_range.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

strobe_msgs::event_t to_message(const Event& event, std::int64_t boot_id, std::int64_t sequence);

strobe_msgs::shot_t to_message(const ShotRecord& record, const Rig& rig, std::int64_t boot_id,
                               SequenceRange sequences, const std::vector<Note>& notes);

/// The rig file's notes; the command's replace those of the same key and follow otherwise.
std::vector<Note> merged(const std::vector<Note>& rig_record, const std::vector<Note>& command);

}  // namespace strobe::firmware
