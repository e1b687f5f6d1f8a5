#include "host/web/archive/session_table.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/redigitize.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/run_record.hpp"
#include "host/session/shot_table.hpp"
#include "host/web/archive/session_folders.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// What `read` makes of a file of the folder; nothing of a link, nor of what cannot be read, which the problem tells.
template <typename Value>
Value own(SessionTable& table, const char* name, Result<Value> (*read)(const fs::path&)) {
  const fs::path path = table.folder / name;
  if (!is_own_file(table.folder, path)) return {};
  auto value = read(path);
  if (value) return std::move(*value);
  if (table.problem.empty()) table.problem = value.error().message;
  return {};
}

Result<std::string> rig_name(const fs::path& path) {
  const auto text = config::read_file(path.string());
  if (!text) return tl::unexpected(text.error());
  const auto rig = host::read_rig(*text, path.filename().string());
  if (!rig) return tl::unexpected(rig.error());
  return rig->rig;
}

/// What all rows have; null where they differ.
template <typename Of>
ordered_json common_json(const std::vector<ShotRow>& rows, Of of) {
  if (rows.empty()) return nullptr;
  for (const ShotRow& row : rows)
    if (of(row) != of(rows.front())) return nullptr;
  return of(rows.front());
}

}  // namespace

SessionTable read_table(const fs::path& folder) {
  SessionTable table;
  table.folder = folder;
  table.rig = own(table, "rig.toml", rig_name);
  table.rows = shot_rows(own(table, "results.csv", host::read_results_rows));
  for (const host::RunRecord& run : own(table, "runs.jsonl", host::read_runs).runs)
    if (table.utc.empty() || run.utc < table.utc) table.utc = run.utc;
  if (table.utc.empty() && !table.rows.empty()) table.utc = table.rows.front().utc;
  return table;
}

ordered_json session_json(const SessionTable& table, bool live) {
  const auto counted =
      std::ranges::count_if(table.rows, [](const ShotRow& row) { return !row.dry && !row.rejected; });
  const auto word = [](const std::string& text) {
    return text.empty() ? ordered_json() : ordered_json(text);
  };
  return {{"id", session_id(table.folder.filename().string())},
          {"utc", word(table.utc)},
          {"shots", table.rows.size()},
          {"counted", counted},
          {"rig", word(table.rig)},
          {"spin", common_json(table.rows, [&](const ShotRow& row) { return word(row.spin); })},
          {"angle_deg",
           common_json(table.rows, [](const ShotRow& row) { return messages::or_null(row.angle_deg); })},
          {"live", live},
          {"problem", word(table.problem)}};
}

Edits edits_of(const fs::path& session) {
  std::vector<std::string> names;
  Edits edits;
  std::error_code error;
  for (fs::directory_iterator entry(session / "digitizations", error), end; !error && entry != end;
       entry.increment(error)) {
    fs::path name = entry->path().filename();
    names.push_back(name.string());
    if (name.extension() == ".undone") name = name.stem();
    if (const auto file = host::digitization_file(name)) edits.shots.insert(file->key);
  }
  std::ranges::sort(names);
  for (const std::string& name : names) edits.state += name + "/";
  return edits;
}

}  // namespace strobe::web
