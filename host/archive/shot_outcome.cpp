#include "host/archive/shot_outcome.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"
#include "host/assembly/assemble.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {

using reduction::Flag;

Shot logged_outcome(const ShotKey& key, const LoggedShot& fired) {
  if (fired.result) return *fired.result;
  if (!fired.summary)
    return interrupted_shot(key, fired.host_id, fired.dry,
                            "its end is in no log: the host, or strobed, ended during the shot");
  reduction::FlagSet flags;
  flags.set(Flag::no_photograph);
  return unmeasured_shot(*fired.summary, flags, "no photograph in the log");
}

/// What another photograph cannot change.
static reduction::FlagSet lasting_flags(const Shot& shot) {
  reduction::FlagSet flags;
  for (const Flag flag : {Flag::events_missing, Flag::clock_suspect})
    if (shot.readout.flags.has(flag)) flags.set(flag);
  return flags;
}

void judge_again(Shot& shot) {
  if (!shot.summary) return;
  assert(shot.rig);
  reduction::FlagSet flags = lasting_flags(shot);
  Shot made;
  if (const strobe_msgs::frame_t* frame = shot.frame()) {
    made = measured_shot(*shot.summary, *frame, flags, assembly_settings(*shot.rig));
  } else {
    flags.set(Flag::no_photograph);
    made = unmeasured_shot(*shot.summary, flags, "no photograph in the log");
  }
  shot.readout = std::move(made.readout);
  shot.train = std::move(made.train);
  shot.rejected = std::move(made.rejected);
  shot.problem = std::move(made.problem);
}

bool never_digitized(const Shot& shot) {
  return shot.summary && shot.photograph && shot.digitizations.empty();
}

std::optional<std::string> never_digitized_remark(const StoredSession& session) {
  std::vector<std::string> names;
  for (const Shot& shot : session.shots)
    if (never_digitized(shot) && !shot.summary->aborted) names.push_back(shot.name);
  if (names.empty()) return std::nullopt;
  return fmt::format("the photograph{} of shot{} {} {} never digitized", names.size() == 1 ? "" : "s",
                     names.size() == 1 ? "" : "s", fmt::join(names, ", "),
                     names.size() == 1 ? "was" : "were");
}

std::string completion_advice(const StoredSession& session) {
  return "strobe replay " + session.folder.string() + " --complete digitizes what was not";
}

Result<Shot> reduced_by(const Shot& shot, reduction::Estimator estimator,
                        const reduction::ReduceOptions& options) {
  const std::string which = "shot " + shot.name;
  if (!shot.summary || shot.digitizations.empty())
    return fail(which + " has no photograph that was digitized");
  const AssembledShot assembled =
      assemble(*shot.summary, shot.digitizations.back().frame, assembly_settings(*shot.rig));
  if (!assembled.problem.empty()) return fail(which + ": " + assembled.problem);
  auto readout = reduction::reduce(assembled.frame, estimator, options);
  if (!readout) return fail(which + ": " + readout.error().message);
  readout->flags.merge(assembled.flags);
  readout->flashes = assembled.flashes;
  Shot result = shot;
  result.readout = std::move(*readout);
  return result;
}

namespace {

namespace fs = std::filesystem;

/// With the columns that its version lacked, empty.
std::string lengthened(std::string line) {
  const std::size_t columns = results_columns().size(), there = data::csv_cells(line).size();
  return line.append(columns > there ? columns - there : 0, ',');
}

/// Rows that there were, in their order, each shot once; then each further shot behind the one fired before
/// it.
std::vector<ShotKey> order(const StoredSession& session, const std::vector<ResultsRow>& rows) {
  std::vector<ShotKey> keys;
  std::set<ShotKey> known;
  for (const ResultsRow& row : rows)
    if (known.insert(row.key).second) keys.push_back(row.key);
  auto place = keys.begin();
  for (const Shot& shot : session.shots) {
    if (known.contains(shot.key())) {
      place = std::next(std::ranges::find(keys, shot.key()));
    } else {
      place = std::next(keys.insert(place, shot.key()));
    }
  }
  return keys;
}

}  // namespace

std::string results_table(const StoredSession& session, const std::vector<ResultsRow>& existing) {
  std::map<ShotKey, std::string> lines;
  for (const ResultsRow& row : existing) lines.try_emplace(row.key, lengthened(row.line));
  for (const Shot& shot : session.shots) lines[shot.key()] = results_line(shot);
  std::string table = results_header() + "\n";
  assert(lines.size() >= session.shots.size());
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
