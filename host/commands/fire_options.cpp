#include "host/commands/fire_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "common/config/files.hpp"
#include "common/messages/record.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> contradiction(const std::string& option, const std::string& before) {
  return fail(fmt::format("--resume: {} contradicts the session's last run, {}", option, before));
}

std::string asked_for(const RunRecord& last) {
  return fmt::format("which was asked for --{} {}", last.until ? "until" : "shots", last.shots);
}

Result<void> check_shots(const FireOptions& given, const RunRecord& last) {
  if (given.shots && (last.until || *given.shots != last.shots))
    return contradiction(fmt::format("--shots {}", *given.shots), asked_for(last));
  if (given.until && (!last.until || *given.until != last.shots))
    return contradiction(fmt::format("--until {}", *given.until), asked_for(last));
  if (given.dry) return fail("--resume: dry shots leave nothing to go on with");
  return {};
}

std::string option_of(const std::string& key, const std::string& value) {
  if (key == "spin") return "--spin " + value;
  return key == "angle_deg" ? "--angle " + value : "--note " + key + "=" + value;
}

Result<void> check_notes(const FireOptions& given, const RunRecord& last) {
  const auto notes = notes_of(given);
  if (!notes) return tl::unexpected(notes.error());
  for (const auto& [key, value] : *notes) {
    const auto before = last.notes.find(key);
    if (before == last.notes.end()) return contradiction(option_of(key, value), "which had no such note");
    if (before->second != value)
      return contradiction(option_of(key, value), "where it was \"" + before->second + "\"");
  }
  return {};
}

Result<void> check_plan_options(const FireOptions& given, const RunRecord& last, const fs::path& stored) {
  if (!given.spacing.empty() && given.spacing != last.spacing)
    return contradiction("--spacing " + given.spacing, "whose plan is gone on with as it is");
  if (given.plan_path.empty()) return {};
  const auto wanted = config::read_file(given.plan_path);
  if (!wanted) return tl::unexpected(wanted.error());
  const auto before = config::read_file(stored.string());
  if (before && *before == *wanted) return {};
  return contradiction("--plan " + given.plan_path, "whose plan is " + stored.string());
}

/// The label's own options, so that the thesis's series is found by them.
void set_labels(const RunRecord& last, FireOptions& options) {
  options.spin.clear();
  options.angle_deg.reset();
  options.notes.clear();
  for (const auto& [key, value] : last.notes) {
    double angle_deg = 0.0;
    if (key == "spin" && (value == "zero" || value == "top" || value == "back")) {
      options.spin = value;
    } else if (key == "angle_deg" &&
               std::from_chars(value.data(), value.data() + value.size(), angle_deg).ptr ==
                   value.data() + value.size()) {
      options.angle_deg = angle_deg;
    } else {
      options.notes.push_back(key + "=" + value);
    }
  }
}

}  // namespace

Result<reduction::Record> notes_of(const FireOptions& options) {
  reduction::Record notes;
  if (!options.spin.empty()) notes["spin"] = options.spin;
  if (options.angle_deg) notes["angle_deg"] = fmt::format("{}", *options.angle_deg);
  for (const std::string& note : options.notes) {
    if (auto added = add_note(notes, note); !added) return fail("--note: " + added.error().message);
  }
  if (notes.size() > messages::kMaxNotes)
    return fail(fmt::format("--note: {} notes, labels included, are more than {}", notes.size(),
                            messages::kMaxNotes));
  return notes;
}

Result<FireOptions> resumed(const FireOptions& given) {
  if (given.session.empty()) return fail("--resume: which session? Name its folder with --session");
  const fs::path folder = given.session;
  const auto read = read_runs(folder / "runs.jsonl");
  if (!read) return tl::unexpected(read.error());
  const std::vector<RunRecord>& runs = read->runs;
  if (runs.empty()) {
    return fail(
        fmt::format("--resume: {} tells of no run to go on with; --until N fires until a session has N shots",
                    (folder / "runs.jsonl").string()));
  }
  const auto found = std::find_if(runs.rbegin(), runs.rend(), [](const RunRecord& run) { return !run.dry; });
  if (found == runs.rend())
    return fail("--resume: the session's runs were dry: there is nothing to go on with");
  const RunRecord& last = *found;
  const fs::path plan = folder / last.plan_file;
  if (auto fits = check_shots(given, last); !fits) return tl::unexpected(fits.error());
  if (auto fits = check_notes(given, last); !fits) return tl::unexpected(fits.error());
  if (auto fits = check_plan_options(given, last, plan); !fits) return tl::unexpected(fits.error());
  FireOptions options = given;
  options.shots.reset();
  options.until = last.session_shots;
  options.plan_path = plan.string();
  options.spacing = last.spacing;
  if (!options.retries) options.retries = last.retries;
  if (options.rig_path.empty()) options.rig_path = last.rig_file;
  if (options.photographs.folder.empty()) options.photographs.folder = last.photographs;
  if (options.photographs.effort == PhotographOptions{}.effort && !last.effort.empty())
    options.photographs.effort = last.effort;
  set_labels(last, options);
  return options;
}

}  // namespace strobe::host
