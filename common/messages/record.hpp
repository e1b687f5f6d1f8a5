// The session's record: free notes to a shot, and the keys among them that have a meaning.
// Pure functions; thread-safe; they allocate.
//
// Keys with a meaning (values are text; numbers in decimal point notation):
//   temperature_c         air temperature at the plate; the court pace needs it
//   frame_number          number of the photograph on its film or in its folder
//   ball_name, ball_grade, surface_name, surface_grade
//   camera_distance_m, machine_distance_m, machine_angle_deg, surface_angle_deg
//   spin, angle_deg       label of the series: "zero", "top" or "back", and the machine's nominal angle
//   operator, remarks
// Any other key of [a-z0-9_.] is passed on.
#pragma once

#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"

namespace strobe_msgs {
class note_t;
}

namespace strobe::messages {

inline constexpr std::size_t kMaxNotes = 64;
inline constexpr std::size_t kLongestNoteKey = 64;
inline constexpr std::size_t kLongestNoteValue = 1024;

/// 1 to 64 characters of [a-z0-9_.].
bool valid_note_key(std::string_view key);

/// In the order of the keys.
std::vector<strobe_msgs::note_t> notes_from_record(const reduction::Record& record);

/// A later note overrides an earlier one of the same key. Fails on a key or value beyond the limits above.
Result<reduction::Record> record_from_notes(const std::vector<strobe_msgs::note_t>& notes);

}  // namespace strobe::messages
