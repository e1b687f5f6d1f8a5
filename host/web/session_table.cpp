#include "host/web/session_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/redigitize.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/record_file.hpp"
#include "host/session/run_record.hpp"
#include "host/session/shot_table.hpp"
#include "host/web/session_folders.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

/// What `read` makes of a file of the folder; nothing of a link, nor of what cannot be read, which the
/// problem tells.
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

/// What the rows name, each once.
std::set<std::string> all_names(const std::vector<ShotRow>& rows, std::string ShotRow::*of) {
  std::set<std::string> names;
  for (const ShotRow& row : rows)
    if (!(row.*of).empty()) names.insert(row.*of);
  return names;
}

std::optional<double> cell_number(const std::string& text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (text.empty() || read.ec != std::errc() || read.ptr != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string> words_between(const std::string& text, char separator) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    if (end > at) words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

/// Where each column is: earlier versions lacked the last ones, none had another order.
class ResultsColumns {
 public:
  ResultsColumns() {
    const auto names = data::csv_cells(host::results_header());
    for (std::size_t i = 0; i < names.size(); ++i) places_[names[i]] = i;
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const std::string quantity(reduction::kQuantityNames[i]);
      value_[i] = places_.at(quantity);
      sd_[i] = places_.at("sd_" + quantity);
      systematic_[i] = places_.at("sd_systematic_" + quantity);
    }
  }

  ShotRow row(const host::ResultsRow& line) const {
    const std::vector<std::string> cells = data::csv_cells(line.line);
    const auto cell = [&](std::size_t at) { return at < cells.size() ? cells[at] : std::string(); };
    const auto named = [&](const char* name) { return cell(places_.at(name)); };
    ShotRow row;
    row.key = line.key;
    row.utc = line.utc;
    if (!line.counts) row.rejected = named("rejected");
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      row.value[q] = cell_number(cell(value_[i]));
      if (const auto sd = cell_number(cell(sd_[i])))
        row.total_sd[q] = std::hypot(*sd, cell_number(cell(systematic_[i])).value_or(0.0));
    }
    row.regime = named("regime");
    row.flags = words_between(named("flags"), ';');
    row.spin = named("spin");
    row.angle_deg = cell_number(named("angle_deg"));
    row.surface = named("surface_name");
    row.ball = named("ball_name");
    row.digitization = named("digitization");
    return row;
  }

 private:
  std::map<std::string, std::size_t> places_;
  std::array<std::size_t, kQuantityCount> value_{}, sd_{}, systematic_{};
};

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
          {"surfaces", all_names(table.rows, &ShotRow::surface)},
          {"balls", all_names(table.rows, &ShotRow::ball)},
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

// Rows of results.csv as the page has them.

std::vector<ShotRow> shot_rows(const std::vector<host::ResultsRow>& results) {
  static const ResultsColumns columns;
  std::vector<ShotRow> rows;
  std::vector<ShotKey> keys;
  std::set<ShotKey> known;
  for (const host::ResultsRow& line : results) {
    if (!known.insert(line.key).second) continue;
    rows.push_back(columns.row(line));
    keys.push_back(line.key);
  }
  std::vector<std::string> names = host::shot_names(keys);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].name = std::move(names[i]);
  return rows;
}

}  // namespace strobe::web
