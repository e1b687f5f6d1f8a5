// strobe series: what the shots of one or several sessions say together.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/command_line/command_line.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/archive/read_session.hpp"
#include "host/commands/command.hpp"
#include "host/commands/series/series_report.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/series/from_session.hpp"

namespace strobe::host {
namespace {

struct SeriesOptions {
  std::vector<std::string> sessions, by, where, without, compare;
  SessionOptions session;
  std::string budget;
  std::optional<double> difference;
  int draws = 0;
  bool all = false, json = false;
};

/// The last folder of the path, "run1" of "data/run1/".
std::string folder_name(const std::string& path) {
  std::filesystem::path folder = std::filesystem::path(path).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  if (folder == "." || folder == "..") folder = std::filesystem::absolute(folder).lexically_normal();
  return folder.has_filename() ? folder.filename().string() : path;
}

/// Folders of one name are told apart by their paths.
std::vector<std::string> names_of(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(folder_name(path));
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto alike = [&](const std::string& other) { return folder_name(other) == folder_name(paths[i]); };
    if (std::ranges::count_if(paths, alike) > 1) names[i] = paths[i];
  }
  return names;
}

Result<std::vector<NamedSession>> read(const SeriesOptions& options) {
  std::vector<NamedSession> sessions;
  const std::vector<std::string> names = names_of(options.sessions);
  for (std::size_t i = 0; i < names.size(); ++i) {
    auto session = read_session(
        options.sessions[i], {options.session.rig_path, options.session.key_file, reading_notes(names[i])});
    if (!session) return tl::unexpected(session.error());
    for (const std::string& remark : session->remarks)
      std::fprintf(stderr, "strobe: %s: %s\n", names[i].c_str(), remark.c_str());
    sessions.push_back({names[i], std::move(*session)});
  }
  return sessions;
}

Result<Selection> selection_of(const SeriesOptions& options) {
  Selection selection;
  selection.without = options.without;
  selection.by = options.by;
  if (selection.by.empty() && !options.compare.empty()) selection.by = {"session"};
  for (const std::string& text : options.where) {
    auto condition = parse_where(text);
    if (!condition) return tl::unexpected(condition.error());
    selection.where.push_back(std::move(*condition));
  }
  return selection;
}

std::optional<reduction::Quantity> quantity_of(const std::string& name) {
  const auto found = std::ranges::find(reduction::kQuantityNames, name);
  if (found == reduction::kQuantityNames.end()) return std::nullopt;
  return static_cast<reduction::Quantity>(found - reduction::kQuantityNames.begin());
}

/// Groups are named by their notes; sessions may be given as paths.
std::string group_name(const std::string& given, const SeriesOptions& options) {
  const auto names = names_of(options.sessions);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (given == options.sessions[i]) return options.by.empty() ? names[i] : given;
  return given;
}

int run_series(const SeriesOptions& options) {
  const auto selection = selection_of(options);
  if (!selection) return bad_input("series: " + selection.error().message);
  const auto sessions = read(options);
  if (!sessions) return bad_input(sessions.error().message);
  std::vector<SeriesShot> shots;
  const bool named = sessions->size() > 1;
  for (const NamedSession& one : *sessions) {
    for (SeriesShot& shot : series_shots(one.session, named ? one.name : ""))
      shots.push_back(std::move(shot));
  }
  const auto selected = select_shots(std::move(shots), *selection);
  if (!selected) return bad_input("series: " + selected.error().message);
  SeriesReportSettings settings{.by = selection->by,
                                .budget = quantity_of(options.budget),
                                .compare = std::nullopt,
                                .difference = options.difference,
                                .draws = options.draws,
                                .all = options.all,
                                .json = options.json};
  if (!options.compare.empty())
    settings.compare = {group_name(options.compare[0], options), group_name(options.compare[1], options)};
  const auto reported = report_series(*sessions, *selected, settings);
  if (!reported) return bad_input("series: " + reported.error().message);
  const auto counts = [](const ShotGroup& group) {
    return std::ranges::any_of(group.shots, [](const SeriesShot& shot) { return !shot.rejected; });
  };
  return std::ranges::any_of(selected->groups, counts) ? kDone : kFailed;
}

std::string one_of_quantities(const std::string& name) {
  if (quantity_of(name)) return "";
  std::string names;
  for (const std::string_view known : reduction::kQuantityNames) names += " " + std::string(known);
  return "no \"" + name + "\" among" + names;
}

}  // namespace

void add_series_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<SeriesOptions>();
  CLI::App* command =
      app.add_subcommand("series", "List, pool and compare the shots of stored sessions, with uncertainties");
  command->add_option("SESSION", options->sessions, "session folders; several are pooled")->required();
  command
      ->add_option("--by", options->by,
                   "a series for each value of these notes, as spin,angle; session: each folder")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--where", options->where, "only shots with this note, as spin=zero; may be repeated")
      ->allow_extra_args(false);
  command
      ->add_option("--without", options->without,
                   "leave a shot out, by its name (of several sessions run1:7), as 7,8; it is told")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option(
          "--compare", options->compare,
          "difference of two series, A less B: names of sessions, or of --by's series as \"zero 23\"")
      ->expected(2);
  command
      ->add_option("--difference", options->difference,
                   "size of the difference, in each quantity's unit, that further shots are counted for "
                   "(default: that found)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--budget", options->budget,
                   "what the uncertainty of this quantity is made of, as vx_td_mps")
      ->check(one_of_quantities);
  command
      ->add_option("--monte-carlo", options->draws,
                   "check each counted shot's intervals with so many draws; 100000 take a second or two")
      ->check(CLI::Range(reduction::kMinDraws, reduction::kMaxDraws));
  add_session_options(*command, options->session);
  command->add_flag("--all", options->all, "every quantity, the slip too");
  command->add_flag("--json", options->json,
                    "one JSON object a series, and one for --compare; nothing else on standard output");
  command_line::for_experts(*command, {"--difference", "--monte-carlo", "--rig", "--key-file", "--all"});
  command->footer(
      "Example: strobe series run1 run2 --by spin,angle --without run1:7\n"
      "         strobe series run1 run2 --compare run1 run2 --difference 0.01\n"
      "Exit status: 0 done, 1 no shot counted, 2 bad usage or input.");
  command->callback([options, &exit_status] { exit_status = run_series(*options); });
}

}  // namespace strobe::host
