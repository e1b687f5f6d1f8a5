// What a session's small files say, without its logs: quick even for a thousand shots. Reads files;
// thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/session/shot_table.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {

struct SessionTable {
  std::filesystem::path folder;
  std::string utc;            ///< of its first run, else of its first shot; empty: not known
  std::string rig;            ///< empty: not known
  std::vector<ShotRow> rows;  ///< of results.csv
  std::string problem;        ///< a line on the first file that cannot be read; empty: none
};

/// Rows of a results.csv, of this version or an earlier one, in its order, each shot once; lines that are
/// none are left out.
std::vector<ShotRow> shot_rows(const std::vector<host::ResultsRow>& results);

/// What cannot be read is absent, and told. A line that a host is still writing is left out.
SessionTable read_table(const std::filesystem::path& folder);

/// {"id","utc","shots","counted","rig","spin","angle_deg","surfaces","balls","live","problem"}: a spin or
/// angle that all shots have, and the names of all surfaces and balls.
nlohmann::ordered_json session_json(const SessionTable& table, bool live);

/// Shots of which a photograph was measured again: results.csv need not know of it.
struct Edits {
  std::string state;        ///< changes with each correction that is made or taken back
  std::set<ShotKey> shots;  ///< those taken back included
};
Edits edits_of(const std::filesystem::path& session);

}  // namespace strobe::web
