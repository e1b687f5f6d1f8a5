// strobe series: what the shots of one or several sessions say together.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/data/thesis_data.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/archive/read_session.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/notes.hpp"
#include "host/design/promise.hpp"
#include "host/series/compare.hpp"
#include "host/series/select.hpp"
#include "host/series/wanted.hpp"
#include "host/view/drift_view.hpp"
#include "host/view/series_json.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

struct SeriesOptions {
  std::vector<std::string> sessions, by, over, where, without, compare;
  SessionOptions session;
  std::string budget, design;
  std::vector<std::string> differences;
  double power = kPower;
  int draws = 0;
  bool all = false, witnesses = false, json = false;
};

struct NamedSession {
  std::string name;  ///< the folder's
  StoredSession session;
};

/// Of --difference. One number alone has a unit only where --budget names the quantity.
Result<reduction::Quantities> asked_differences(const SeriesOptions& options) {
  const auto wanted = parse_wanted("--difference", options.differences, Percent::refused, options.budget);
  if (!wanted) return tl::unexpected(wanted.error());
  reduction::Quantities asked;
  for (const Wanted& each : *wanted) asked[each.quantity] = each.value;
  return asked;
}

constexpr std::uint64_t kSeed = 1;

void print_json(const ordered_json& object) { print({messages::json_text(object)}); }

/// The thesis's row where all shots have one spin and angle.
std::optional<thesis::Condition> condition_of(const std::vector<Shot>& shots) {
  std::optional<std::string> spin;
  std::optional<double> angle;
  for (const Shot& shot : shots) {
    const auto note = shot.readout.record.find("spin");
    const auto its_angle = note_number(shot.readout.record, "angle_deg");
    if (note == shot.readout.record.end() || !its_angle) return std::nullopt;
    if ((spin && *spin != note->second) || (angle && *angle != *its_angle)) return std::nullopt;
    spin = note->second;
    angle = its_angle;
  }
  return spin ? thesis::shipped_condition(*spin, *angle) : std::nullopt;
}

Series series_of(const std::vector<Shot>& shots) {
  Series series;
  for (const Shot& shot : shots) series.add(shot);
  return series;
}

std::string group_name(const ShotGroup& group, const std::vector<NamedSession>& sessions) {
  if (!group.name.empty()) return group.name;
  std::string names;
  for (const NamedSession& session : sessions) names += (names.empty() ? "" : " + ") + session.name;
  return names;
}

/// Which shots there are, for a person.
std::vector<std::string> shot_lines(const ShotGroup& group) {
  std::string counted;
  std::vector<std::string> lines;
  for (const Shot& shot : group.shots) {
    if (shot.rejected)
      lines.push_back(fmt::format("  shot {} rejected: {}", shot.full_name(), *shot.rejected));
    else
      counted += (counted.empty() ? "" : ", ") + shot.full_name();
  }
  if (!counted.empty()) lines.insert(lines.begin(), "  shots " + counted);
  return lines;
}

ordered_json shots_json(const ShotGroup& group) {
  ordered_json shots = ordered_json::array();
  for (const Shot& shot : group.shots) {
    shots.push_back(
        {{"shot", shot.name}, {"session", shot.session}, {"rejected", messages::or_null(shot.rejected)}});
  }
  return shots;
}

class SeriesPrinter {
 public:
  SeriesPrinter(const std::vector<NamedSession>& sessions, const SelectedShots& selected,
                const SeriesOptions& settings, const reduction::Quantities& differences,
                const std::optional<Promise>& promise)
      : sessions_(sessions),
        selected_(selected),
        settings_(settings),
        differences_(differences),
        promise_(promise) {}

  Result<void> run() {
    if (!settings_.json) head();
    for (const ShotGroup& group : selected_.groups) put(group);
    if (settings_.compare.empty()) return {};
    const auto first = find(settings_.compare[0]), second = find(settings_.compare[1]);
    if (!first) return tl::unexpected(first.error());
    if (!second) return tl::unexpected(second.error());
    put(**first, **second);
    return {};
  }

 private:
  void head() const {
    std::string left_out;
    for (const std::string& name : selected_.left_out) left_out += (left_out.empty() ? "" : ", ") + name;
    if (!left_out.empty()) print({"left out as asked: shot " + left_out});
    if (selected_.other > 0) print({fmt::format("{} shots have other notes", selected_.other)});
    if (selected_.groups.empty()) print({"no shots"});
  }

  void put(const ShotGroup& group) {
    const std::string name = group_name(group, sessions_);
    const SeriesSummary summary = summarize(name, group.shots);
    const auto condition = condition_of(group.shots);
    if (settings_.json) {
      ordered_json object = series_json(summary, condition);
      object["shots"] = shots_json(group);
      object["left_out"] = selected_.left_out;
      object["witnesses"] = drift_json(charts_of(group.shots));
      if (promise_) object["promise"] = kept_json(kept(*promise_, summary, group.shots));
      if (settings_.draws > 0) object["monte_carlo"] = drawn_json(group);
      return print_json(object);
    }
    print(render_summary(summary, condition, kPlainWidth, settings_.all));
    print(shot_lines(group));
    if (promise_) print(render_kept(kept(*promise_, summary, group.shots), kPlainWidth));
    const WitnessCharts charts = charts_of(group.shots);
    print(render_drift(charts));
    if (settings_.witnesses) print(render_witnesses(charts));
    if (const auto q = find_quantity(settings_.budget)) {
      const auto& lines = summary.quantities[static_cast<std::size_t>(*q)].budget;
      print(render_budget(name + ", mean", lines, *q, kPlainWidth));
    }
    if (settings_.draws > 0) print_drawn(group);
    print({""});
  }

  void put(const ShotGroup& first, const ShotGroup& second) const {
    const Comparison comparison =
        compare(series_of(first.shots), series_of(second.shots), differences_, settings_.power);
    if (settings_.json) return print_json(comparison_json(first.name, second.name, comparison));
    print(render_comparison(first.name, second.name, comparison, kPlainWidth, settings_.all));
  }

  Result<const ShotGroup*> find(const std::string& name) const {
    std::string names;
    for (const ShotGroup& group : selected_.groups) {
      if (group.name == name) return &group;
      names += (names.empty() ? "\"" : ", \"") + group.name + "\"";
    }
    return fail(fmt::format("--compare: no series \"{}\" among {}", name, names.empty() ? "none" : names));
  }

  /// Of the stored shot of that name.
  std::optional<reduction::MonteCarlo> drawn(const Shot& wanted) const {
    for (const NamedSession& session : sessions_) {
      if (!wanted.session.empty() && wanted.session != session.name) continue;
      for (const Shot& stored : session.session.shots) {
        if (stored.name != wanted.name) continue;
        const auto frame = matched_frame(stored);
        if (!frame) return std::nullopt;
        const auto result = reduction::monte_carlo(*frame, settings_.draws, kSeed);
        return result ? std::optional(*result) : std::nullopt;
      }
    }
    return std::nullopt;
  }

  ordered_json drawn_json(const ShotGroup& group) const {
    ordered_json all = ordered_json::array();
    for (const Shot& shot : group.shots) {
      if (shot.rejected) continue;
      const auto result = drawn(shot);
      ordered_json object = result ? monte_carlo_json(*result) : ordered_json::object();
      object["shot"] = shot.full_name();
      all.push_back(std::move(object));
    }
    return all;
  }

  void print_drawn(const ShotGroup& group) const {
    for (const Shot& shot : group.shots) {
      if (shot.rejected) continue;
      const auto result = drawn(shot);
      if (result) print(render_monte_carlo(*result, shot.full_name(), kPlainWidth, settings_.all));
    }
  }

  const std::vector<NamedSession>& sessions_;
  const SelectedShots& selected_;
  const SeriesOptions& settings_;
  const reduction::Quantities& differences_;
  const std::optional<Promise>& promise_;
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
    for (const auto& told : {session->remarks, session->advice})
      for (const std::string& line : told)
        std::fprintf(stderr, "strobe: %s: %s\n", names[i].c_str(), line.c_str());
    sessions.push_back({names[i], std::move(*session)});
  }
  return sessions;
}

Result<Selection> selection_of(const SeriesOptions& options) {
  Selection selection;
  selection.without = options.without;
  selection.by = options.by;
  selection.over = options.over;
  if (selection.by.empty() && !options.compare.empty()) selection.by = {"session"};
  for (const std::string& text : options.where) {
    auto condition = parse_where(text);
    if (!condition) return tl::unexpected(condition.error());
    selection.where.push_back(std::move(*condition));
  }
  return selection;
}

/// Groups are named by their notes; sessions may be given as paths.
std::string group_name(const std::string& given, const SeriesOptions& options) {
  const auto names = names_of(options.sessions);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (given == options.sessions[i]) return options.by.empty() ? names[i] : given;
  return given;
}

/// Of --design, or what one session was fired with.
Result<std::optional<Promise>> promise_for(const SeriesOptions& options) {
  if (options.design.empty())
    return options.sessions.size() == 1 ? promise_of(options.sessions.front()) : std::optional<Promise>();
  const auto text = read_option_file("--design", options.design);
  if (!text) return tl::unexpected(text.error());
  auto promise = parse_promise(*text, options.design);
  if (!promise) return fail("--design: " + promise.error().message);
  return std::optional(std::move(*promise));
}

int run_series(const SeriesOptions& options) {
  const auto selection = selection_of(options);
  if (!selection) return bad_input("series: " + selection.error().message);
  const auto differences = asked_differences(options);
  if (!differences) return bad_input("series: " + differences.error().message);
  const auto sessions = read(options);
  if (!sessions) return bad_input(sessions.error().message);
  std::vector<Shot> shots;
  const bool named = sessions->size() > 1;
  for (const NamedSession& one : *sessions) {
    for (Shot& shot : series_shots(one.session, named ? one.name : "")) shots.push_back(std::move(shot));
  }
  const auto selected = select_shots(std::move(shots), *selection);
  if (!selected) return bad_input("series: " + selected.error().message);
  for (const ShotGroup& group : selected->groups) {
    if (!group.mixed.empty())
      std::fprintf(stderr, "strobe: %s: a mean over %s, in which its shots differ\n",
                   group.name.empty() ? "all shots" : group.name.c_str(),
                   fmt::format("{}", fmt::join(group.mixed, ", ")).c_str());
  }
  const auto promise = promise_for(options);
  if (!promise) return bad_input("series: " + promise.error().message);
  SeriesOptions settings = options;
  for (std::string& name : settings.compare) name = group_name(name, options);
  const auto reported = SeriesPrinter(*sessions, *selected, settings, *differences, *promise).run();
  if (!reported) return bad_input("series: " + reported.error().message);
  const auto counts = [](const ShotGroup& group) {
    return std::ranges::any_of(group.shots, [](const Shot& shot) { return !shot.rejected; });
  };
  return std::ranges::any_of(selected->groups, counts) ? kDone : kFailed;
}

std::string one_of_quantities(const std::string& name) {
  const auto q = find_quantity(name);
  return q ? "" : q.error().message;
}

}  // namespace

void add_series_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<SeriesOptions>();
  CLI::App* command = app.add_subcommand("series", "Pool and compare the shots of stored sessions");
  command->add_option("SESSION", options->sessions, "session folders; shots of one condition are pooled")
      ->required();
  command
      ->add_option("--by", options->by,
                   "a series for each value of these notes, as spin,angle; session: each folder (default: of "
                   "what the shots differ in: spin, angle, surface, ball, operator, temperature, rig, "
                   "calibration, plan)")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_over_option(*command, options->over);
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
      ->add_option("--difference", options->differences,
                   "what further shots are to find, as e:0.005,omega_lo:5; a number alone is for --budget's "
                   "quantity (default: the difference found)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--power", options->power,
                   "the probability with which further shots are to find the difference (default 0.8)")
      ->check(CLI::Range(kMinPower, kMaxPower));
  command
      ->add_option("--budget", options->budget,
                   "what the uncertainty of this quantity is made of, as vx_td_mps")
      ->check(one_of_quantities);
  command->add_option(
      "--design", options->design,
      "what `strobe design --json` promised, beside what became of it (default: that with which the "
      "session was fired)");
  command
      ->add_option("--monte-carlo", options->draws,
                   "check each counted shot's intervals with so many draws; 100000 take a second or two")
      ->check(CLI::Range(reduction::kMinDraws, reduction::kMaxDraws));
  add_session_options(*command, options->session);
  command->add_flag("--all", options->all, "every quantity, the slip too");
  command->add_flag(
      "--witnesses", options->witnesses,
      "what each shot says of scale, clock, inclination, lens and lamps, with control charts' sums");
  command->add_flag("--json", options->json,
                    "one JSON object a series, and one for --compare; nothing else on standard output");
  command_line::for_experts(*command, {"--design", "--difference", "--power", "--monte-carlo", "--rig",
                                       "--key-file", "--all", "--witnesses"});
  command->footer(
      "Example: strobe series run1 run2 --by spin,angle --without run1:7\n"
      "         strobe series run1 run2 --compare run1 run2 --difference e:0.01 --power 0.9\n"
      "Exit status: 0 done, 1 no shot counted, 2 bad usage or input.");
  command->callback([options, &exit_status] { exit_status = run_series(*options); });
}

}  // namespace strobe::host
