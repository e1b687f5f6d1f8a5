// The record of a session: notes "key = value" from the rig file's [record], the command line and the
// firmware. No I/O; thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"

namespace strobe::host {

/// Keys with a meaning of their own: shown by name and given a column of results.csv. Any other key is kept
/// too.
inline constexpr std::array<std::string_view, 14> kNamedNotes{"spin",
                                                              "angle_deg",
                                                              "frame_number",
                                                              "ball_name",
                                                              "ball_grade",
                                                              "surface_name",
                                                              "surface_grade",
                                                              "temperature_c",
                                                              "camera_distance_m",
                                                              "machine_distance_m",
                                                              "machine_angle_deg",
                                                              "surface_angle_deg",
                                                              "operator",
                                                              "remarks"};

/// What is wrong with the note, or nothing: keys are 1 to 64 of [a-z0-9_.], values UTF-8 of at most 1024
/// bytes without control characters.
std::optional<std::string> note_problem(std::string_view key, std::string_view value);

/// Adds "key=value" (spaces around both are dropped), replacing an entry of the same key.
Result<void> add_note(reduction::Record& record, std::string_view text);

/// The note read as a number, if there is one and it is a finite number through to its end.
std::optional<double> note_number(const reduction::Record& record, std::string_view key);

}  // namespace strobe::host
