// Which shots make a series: filtered and grouped by their notes. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "host/series/series_shot.hpp"

namespace strobe::host {

struct Selection {
  std::vector<std::pair<std::string, std::string>> where;  ///< note and value; numbers are compared as such
  std::vector<std::string> without;                        ///< names of shots, full or not
  std::vector<std::string> by;                             ///< notes; "session" is the folder
};

struct ShotGroup {
  std::string name;  ///< "zero 23": the notes' values in the order of Selection::by; empty without any
  std::vector<SeriesShot> shots;
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
Result<SelectedShots> select_shots(std::vector<SeriesShot> shots, const Selection& selection);

}  // namespace strobe::host
