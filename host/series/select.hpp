// Which shots make a series: filtered and grouped by their notes. Pure; thread-safe; allocates.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "host/archive/read_session.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

/// What shots may differ in so that they are not of one condition: notes of their record, and by what they
/// were fired and measured.
inline constexpr std::array<std::string_view, 12> kConditionKeys{
    "spin",       "angle_deg", "surface_name",  "surface_grade", "surface_angle_deg", "ball_name",
    "ball_grade", "operator",  "temperature_c", "rig",           "calibration",       "plan"};

/// Of a note, of "session", or of kConditionKeys; empty: the shot has none.
std::string value_of(const Shot& shot, const std::string& key);

/// Those of kConditionKeys in which the shots differ, but for `over`; numbers are compared as such.
std::vector<std::string> differing_keys(const std::vector<const Shot*>& shots,
                                        const std::vector<std::string>& over = {});

struct Selection {
  std::vector<std::pair<std::string, std::string>> where{};  ///< note and value; numbers are compared as such
  std::vector<std::string> without{};                        ///< names of shots, full or not
  /// Notes; "session" is the folder. Empty: what the shots differ in, so that no mean is over what differs.
  std::vector<std::string> by{};
  std::vector<std::string> over{};  ///< notes that do not divide, though shots differ in them
};

struct ShotGroup {
  std::string name;  ///< "zero 23": the notes' values in the order of Selection::by; empty without any
  std::vector<Shot> shots;
  std::vector<std::string> mixed{};  ///< differing_keys() of its shots: a mean of them is over these
};

struct SelectedShots {
  std::vector<ShotGroup> groups;      ///< by value, numbers by size
  std::vector<std::string> left_out;  ///< full names, as asked for
  int other = 0;                      ///< shots that `where` does not name
};

/// "angle" is angle_deg, others are themselves.
std::string note_key(const std::string& word);

/// "key=value". Fails for what is none.
Result<std::pair<std::string, std::string>> parse_where(const std::string& text);

/// Fails for a shot to be left out that is not there, or whose name several sessions have.
Result<SelectedShots> select_shots(std::vector<Shot> shots, const Selection& selection);

// The shots of a stored session as a series takes them. No I/O; thread-safe; allocates; some milliseconds a
// shot.

/// A stored shot with its budget, if it counts, and with whose errors it shares; without its messages, which
/// a series needs no more.
Shot series_shot(const Shot& stored);

/// `session`: what its shots are called by, empty where there is one session only. Calibration and ball are
/// those of the shot's rig file, the ball also by its note ball_name: balls that no note tells apart are
/// taken for the same.
std::vector<Shot> series_shots(const StoredSession& session, const std::string& session_name);

/// The shot's frame with the likeliest times of its flashes; absent without one.
std::optional<reduction::Frame> matched_frame(const Shot& shot);

/// Of the digitization that counts; empty without one.
reduction::Budget budget_of(const Shot& shot);

}  // namespace strobe::host
