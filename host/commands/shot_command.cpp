// strobe shot: one shot of a session again.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/command_line/command_line.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/digitize/overlay.hpp"
#include "host/series/select.hpp"
#include "host/series/series.hpp"
#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"
#include "host/view/series_json.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using reduction::Quantity;

/// As it is called in the session.
std::string within(const StoredSession& session, const std::filesystem::path& file) {
  return file.lexically_relative(session.folder).string();
}

ordered_json digitization_json(const StoredSession& session, const Digitization& digitization, bool counts) {
  const auto file = [&](const std::filesystem::path& path) {
    return path.empty() ? ordered_json(nullptr) : ordered_json(within(session, path));
  };
  ordered_json json;
  json["digitization"] = digitization_word(digitization);
  json["images"] = digitization.frame.images.size();
  json["utc"] = digitization.utc;
  json["who"] = digitization.who.empty() ? ordered_json(nullptr) : ordered_json(digitization.who);
  json["file"] = file(digitization.file);
  json["corrections"] = file(digitization.corrections);
  json["counts"] = counts;
  return json;
}

/// With its total standard uncertainty, as the readout above has it.
std::string cell(const reduction::Readout& readout, Quantity quantity) {
  const auto& value = readout.value[quantity];
  if (!value) return right("-", 20);
  const auto sd = reduction::total_sd(readout, quantity);
  return right(rounded(*value, sd.value_or(0.0), sd ? 0 : 3), 11) +
         (sd ? left(fmt::format(" ± {:#.2g}", *sd), 11) : "");
}

/// Keys in fixed order, what is absent null. before: before a change; null: there was none, and the key is
/// left out.
std::string measurement_json(const StoredSession& session, const Shot& shot, const Shot* before) {
  ordered_json json;
  json["shot"] = shot.name;
  json["utc"] = shot.utc;
  json["counts"] = !shot.rejected;
  json["rejected"] = messages::or_null(shot.rejected);
  json["photograph"] =
      shot.photograph ? ordered_json(within(session, *shot.photograph)) : ordered_json(nullptr);
  json["digitizations"] = ordered_json::array();
  for (const Digitization& each : shot.digitizations)
    json["digitizations"].push_back(digitization_json(session, each, &each == &shot.digitizations.back()));
  if (before != nullptr) json["before"] = messages::readout_json(before->readout);
  return messages::json_text(json);
}

/// Which photograph, which digitizations, which of them counts.
std::vector<std::string> measurement_lines(const StoredSession& session, const Shot& shot) {
  std::vector<std::string> lines;
  lines.push_back(shot.photograph ? "photograph: " + within(session, *shot.photograph)
                                  : "no photograph of it is in the session");
  for (const Digitization& each : shot.digitizations) {
    const bool counts = &each == &shot.digitizations.back();
    std::string line = fmt::format("  {}{} {} images  {}", counts ? "* " : "  ",
                                   left(digitization_word(each), 10), each.frame.images.size(), each.utc);
    if (!each.who.empty()) line += " by " + each.who;
    if (!each.file.empty()) line += "  " + within(session, each.file);
    lines.push_back(line + (counts && shot.digitizations.size() > 1 ? "  (counts)" : ""));
  }
  if (shot.digitizations.empty()) lines.push_back("  not digitized");
  return lines;
}

/// Each number before and after a change of the digitization.
std::vector<std::string> comparison_lines(const Shot& before, const Shot& after) {
  std::vector<std::string> lines{left("", 24) + right("before", 11) + left(" ± sd", 11) + right("after", 11) +
                                 " ± sd"};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<Quantity>(i);
    if (!before.readout.value[quantity] && !after.readout.value[quantity]) continue;
    const std::string label =
        fmt::format("{}{}{}", kQuantityLabels[i].words, kQuantityLabels[i].unit.empty() ? "" : " ",
                    kQuantityLabels[i].unit);
    lines.push_back(left(label, 24) + left(cell(before.readout, quantity), 22) +
                    cell(after.readout, quantity));
  }
  const auto verdict = [](const Shot& result) {
    return result.rejected ? "rejected: " + *result.rejected : "counts";
  };
  lines.push_back("before: " + verdict(before));
  lines.push_back("after:  " + verdict(after));
  return lines;
}

struct ShotOptions {
  std::string session;
  std::string name;
  SessionOptions reading;
  std::string estimator = "best";
  std::string noise = "stated";
  std::string edit_file;  ///< empty: none
  bool undo_edit = false;
  std::string overlay;  ///< empty: none
  bool explain = false;
  bool budget = false;
  bool json = false;

  bool reduces() const { return estimator != "best" || noise != "stated"; }
};

/// What the options ask to be done with the session: the shot as it is then.
Result<ChangedShot> change(const ShotOptions& options, const StoredSession& session, const Shot& shot) {
  if (options.undo_edit) return take_back(session, shot);
  if (options.edit_file.empty()) return ChangedShot{shot, false};
  const auto corrections = read_option_file("--edit", options.edit_file);
  if (!corrections) return tl::unexpected(corrections.error());
  return put_correction(session, shot, *corrections, options.edit_file, author_now());
}

Result<void> draw(const ShotOptions& options, const StoredSession& session, const Shot& shot) {
  const auto measured = redigitize_newest(session, shot);
  if (!measured) return tl::unexpected(measured.error());
  return digitize::write_overlay(options.overlay, measured->photograph, measured->settings.map,
                                 measured->found, {.rejected = options.explain});
}

/// For a program one object; for a person a table for each essential number.
std::vector<std::string> budget_lines_of(const Shot& shot, bool json) {
  const reduction::Budget budget = budget_of(shot);
  const reduction::Readout& readout = shot.readout;
  if (json) {
    nlohmann::ordered_json object{{"shot", shot.name}};
    object["budget"] = budget_json(budget, readout);
    return {messages::json_text(object)};
  }
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<reduction::Quantity>(i);
    if (!readout.value[q] || !is_essential(q)) continue;
    for (std::string& line : render_budget("shot " + shot.name, budget_lines(budget, q), q, kPlainWidth))
      lines.push_back(std::move(line));
  }
  return lines;
}

int run_shot(const ShotOptions& options) {
  if (options.noise != "stated" && options.estimator != "best")
    return bad_input("shot: --noise residuals needs --estimator best");
  if (options.budget && options.reduces())
    return bad_input("shot: --budget needs --estimator best and --noise stated");
  Terminal terminal(Terminal::style(options.json, true));
  const auto session = read_for(terminal, options.session, options.reading);
  if (!session) return bad_input(session.error().message);
  const auto shot = find_shot(*session, options.name);
  if (!shot) return bad_input(shot.error().message);
  const auto changed = change(options, *session, **shot);
  if (!changed) return bad_input(changed.error().message);
  Shot result = changed->shot;
  if (options.reduces()) {
    reduction::ReduceOptions how;
    how.noise = *reduction::noise_source_from_name(options.noise);
    how.likely_cause = true;
    auto reduced = reduced_by(changed->shot, *reduction::estimator_from_name(options.estimator), how);
    if (!reduced) return bad_input(reduced.error().message);
    result = std::move(*reduced);
  }
  if (!options.overlay.empty()) {
    if (auto drawn = draw(options, *session, changed->shot); !drawn) return bad_input(drawn.error().message);
  }
  terminal.on_shot_result(result);
  const Shot* before = changed->changed ? &*(*shot) : nullptr;
  if (options.json) {
    print({measurement_json(*session, changed->shot, before)});
  } else {
    if (before != nullptr) print(comparison_lines(*before, result));
    print(measurement_lines(*session, changed->shot));
  }
  if (options.budget) print(budget_lines_of(changed->shot, options.json));
  if (changed->changed)
    terminal.note(
        fmt::format("results.csv still has the former numbers; strobe replay {} --results writes it anew",
                    options.session));
  if (!options.edit_file.empty() && !changed->changed) terminal.note("these corrections count already");
  return kDone;
}

}  // namespace

void add_shot_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ShotOptions>();
  CLI::App* command = app.add_subcommand("shot", "One shot of a session again; correct its digitization");
  command->add_option("SESSION", options->session, "the session's folder")->required();
  command->add_option("SHOT", options->name, "its number, as on the screen and in results.csv (column shot)")
      ->required();
  CLI::Option* edit = command->add_option(
      "--edit", options->edit_file,
      "correct the digitization of its photograph by this file (see strobe digitize); the "
      "corrected one is kept in the session beside the first, and counts");
  command
      ->add_flag("--undo-edit", options->undo_edit,
                 "take the newest correction back; the one before it counts again")
      ->excludes(edit);
  CLI::Option* overlay = command->add_option(
      "--overlay", options->overlay, "draw what was found on the photograph, as a PNG, TIFF or JPEG file");
  command->add_flag("--explain", options->explain, "draw what was rejected, too, with the reason")
      ->needs(overlay);
  command->add_option("--estimator", options->estimator, "best (default), two-point or legacy")
      ->check(CLI::IsMember({"best", "two-point", "legacy"}));
  command->add_option("--noise", options->noise, "as of strobe reduce: stated (default) or residuals")
      ->check(CLI::IsMember({"stated", "residuals"}));
  command->add_flag("--budget", options->budget, "what each number's uncertainty is made of");
  add_session_options(*command, options->reading);
  command->add_flag(
      "--json", options->json,
      "on standard output the readout as of strobe replay --json, then an object that tells its photograph "
      "and digitizations; nothing else there");
  command->footer(
      "Examples: strobe shot run1 3\n"
      "          strobe shot run1 3 --overlay shot3.png\n"
      "          strobe shot run1 3 --edit corrections.toml\n"
      "Exit status: 2 if there is no such shot, or it cannot be done.");
  command_line::for_experts(*command, {"--noise", "--budget", "--explain", "--rig", "--key-file"});
  command->callback([options, &exit_status] { exit_status = run_shot(*options); });
}

}  // namespace strobe::host
