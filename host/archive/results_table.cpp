#include "host/archive/results_table.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/config/files.hpp"
#include "host/session/data_dictionary.hpp"
#include "host/session/results_csv.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

std::ptrdiff_t cells(std::string_view line) {
  bool quoted = false;
  return 1 + std::ranges::count_if(line, [&quoted](char c) {
           if (c == '"') quoted = !quoted;
           return c == ',' && !quoted;
         });
}

/// With the columns that its version lacked, empty.
std::string lengthened(std::string line) {
  const auto missing = static_cast<std::ptrdiff_t>(results_columns().size()) - cells(line);
  return line.append(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, missing)), ',');
}

/// Rows that there were, in their order, each shot once; then each further shot behind the one fired before it.
std::vector<ShotKey> order(const StoredSession& session, const std::vector<ResultsRow>& rows) {
  std::vector<ShotKey> keys;
  std::set<ShotKey> known;
  for (const ResultsRow& row : rows)
    if (known.insert(row.key).second) keys.push_back(row.key);
  auto place = keys.begin();
  for (const StoredShot& shot : session.shots) {
    if (known.contains(shot.key)) {
      place = std::next(std::ranges::find(keys, shot.key));
    } else {
      place = std::next(keys.insert(place, shot.key));
    }
  }
  return keys;
}

}  // namespace

std::string_view digitization_word(const StoredShot& shot) {
  if (shot.digitizations.empty()) return "";
  const Digitization& counts = shot.digitizations.back();
  if (!counts.file.empty() && counts.by_hand) return kCorrectedWord;
  return digitization_word(shot.result);
}

std::string results_table(const StoredSession& session, const std::vector<ResultsRow>& existing) {
  std::map<ShotKey, std::string> lines;
  for (const ResultsRow& row : existing) lines.try_emplace(row.key, lengthened(row.line));
  for (const StoredShot& shot : session.shots)
    lines[shot.key] = results_line(shot.result, shot.utc, shot.name, digitization_word(shot));
  std::string table = results_header() + "\n";
  for (const ShotKey& key : order(session, existing)) table += lines.at(key) + "\n";
  return table;
}

Result<void> rebuild_results(const StoredSession& session, const fs::path& file) {
  const auto rows = read_results_rows(session.folder / "results.csv");
  if (!rows) return tl::unexpected(rows.error());
  if (auto written = config::write_file(file, results_table(session, *rows)); !written) return written;
  return config::write_file(file.string() + "-metadata.json",
                            data_dictionary(file.filename().string(), kResultsTitle, results_columns()));
}

}  // namespace strobe::host
