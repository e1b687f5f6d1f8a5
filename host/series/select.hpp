// Which shots make a series: filtered and grouped by their notes. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "host/archive/read_session.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

struct Selection {
  std::vector<std::pair<std::string, std::string>> where;  ///< note and value; numbers are compared as such
  std::vector<std::string> without;                        ///< names of shots, full or not
  std::vector<std::string> by;                             ///< notes; "session" is the folder
};

struct ShotGroup {
  std::string name;  ///< "zero 23": the notes' values in the order of Selection::by; empty without any
  std::vector<Shot> shots;
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
