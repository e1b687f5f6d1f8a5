#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "common/authentication/key_file.hpp"
#include "common/command_line/command_line.hpp"
#include "host/archive/log_player.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/config/notes.hpp"
#include "host/series/select.hpp"
#include "host/session/run_lock.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

struct ReplayOptions {
  std::string path;
  SessionOptions reading;
  std::string shot;                    ///< empty: all
  std::optional<std::string> results;  ///< file; empty: the session's own
  bool complete = false;
  bool json = false;
};

/// --rig, else the rig file kept beside the log, else the shipped example.
std::string rig_path(const ReplayOptions& options) {
  if (!options.reading.rig_path.empty()) return options.reading.rig_path;
  const auto beside = fs::path(options.path).parent_path() / "rig.toml";
  std::error_code error;
  return fs::exists(beside, error) ? beside.string() : std::string();
}

std::optional<authentication::Key> sealing_key(const ReplayOptions& options, const RigFile& rig) {
  const auto key = authentication::find_key({options.reading.key_file, rig.key_file.value_or("")});
  if (!key || !is_sealed(options.path, rig.rig, key->key).value_or(false)) return std::nullopt;
  return key->key;
}

/// Shows the results of one shot, or of all.
class ChosenShot final : public HostListener {
 public:
  ChosenShot(Terminal& terminal, std::string name) : terminal_(terminal), name_(std::move(name)) {}

  void on_shot_result(const Shot& result) override {
    if (!result.dry) shots_.push_back(result.key());
    if (name_.empty() || (!result.dry && shot_names(shots_).back() == name_))
      terminal_.on_shot_result(result);
  }
  void on_notification(const std::string& text) override { terminal_.on_notification(text); }

 private:
  Terminal& terminal_;
  std::string name_;
  std::vector<ShotKey> shots_;
};

/// The journal of a firmware that ended in a shot says no more of it.
void show_unfinished(const FiredShots& fired, ChosenShot& shown) {
  for (const auto& [key, shot] : fired.all())
    if (!shot.result) shown.on_shot_result(logged_outcome(key, shot));
}

int conclude(const ReplayOptions& options, Terminal& terminal, const std::string& rig,
             std::int64_t messages) {
  if (!options.json && options.shot.empty())
    print(render_series(terminal.model().series, std::nullopt, kPlainWidth));
  if (terminal.model().shots > 0) return kDone;
  const std::string which = options.shot.empty() ? "no shot" : "no shot " + options.shot;
  return failed(fmt::format("{}: {} of rig {} in {} messages", options.path, which, rig, messages));
}

int replay_log(const ReplayOptions& options) {
  if (options.results || options.complete)
    return bad_input(options.path + ": --results and --complete are for a session's folder");
  const auto rig = load_rig(rig_path(options));
  if (!rig) return bad_input(rig.error().message);
  auto log = StoredLogs::open({options.path});
  if (!log) return bad_input(log.error().message);
  LogPlayer player(*rig, sealing_key(options, *rig), !options.json);
  FiredShots fired(player, rig->rig);
  Terminal terminal(Terminal::style(options.json, true));
  ChosenShot shown(terminal, options.shot);
  player.loop().add_listener(shown);
  if (!player.loop().verifies())
    terminal.note("unverified: the log has no seal of this host's key (see strobe key)");
  player.play(*log);
  player.end();
  if (log->messages() == 0) return bad_input(options.path + ": not an LCM log, or an empty one");
  if (fs::path(options.path).filename().string().starts_with("journal-")) show_unfinished(fired, shown);
  return conclude(options, terminal, rig->rig, log->messages());
}

int replay_session(const ReplayOptions& options) {
  Terminal terminal(Terminal::style(options.json, true));
  auto session = read_for(terminal, options.path, options.reading);
  if (!session) return bad_input(session.error().message);
  if (!options.shot.empty()) {
    if (const auto shot = find_shot(*session, options.shot); !shot) return bad_input(shot.error().message);
  }
  if (options.complete) {
    const Completion done = complete(*session);
    terminal.note(fmt::format("{} photograph{} digitized", done.digitized, done.digitized == 1 ? "" : "s"));
    for (const std::string& problem : done.problems) terminal.note(problem);
  }
  for (Shot& shot : session->shots) {
    if (!options.shot.empty() && shot.name != options.shot) continue;
    // A person's series tells what its shots share.
    if (!options.json && !shot.rejected) shot.budget = budget_of(shot);
    terminal.on_shot_result(shot);
  }
  if (options.results) {
    const fs::path file =
        options.results->empty() ? session->folder / "results.csv" : fs::path(*options.results);
    if (auto written = rebuild_results(*session, file); !written) return failed(written.error().message);
  }
  if (!options.json && options.shot.empty())
    print(render_series(terminal.model().series, std::nullopt, kPlainWidth));
  if (session->shots.empty()) return failed(options.path + ": no shot was fired");
  return kDone;
}

int run_replay(const ReplayOptions& options) {
  std::error_code error;
  if (!fs::is_directory(options.path, error)) return replay_log(options);
  if (!options.results || !options.results->empty()) return replay_session(options);
  // Its own table is made anew: nobody may append to it meanwhile.
  const auto lock = RunLock::of_session(options.path, operator_name(), MachineClock().read().wall);
  return lock ? replay_session(options) : bad_input(lock.error().message);
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "Compute the readouts of a recorded session again");
  command
      ->add_option(
          "SESSION|LOG", options->path,
          "a session's folder, with its photographs' newest digitizations; or an LCM log: a host's, a "
          "journal, lcm-logger's")
      ->required();
  command->add_option("--shot", options->shot, "only the shot of this name (column shot of results.csv)");
  command
      ->add_option_function<std::string>(
          "--results", [options](const std::string& file) { options->results = file; },
          "of a folder: write results.csv anew, every shot once, or the table to this file")
      ->expected(0, 1)
      ->type_name("[FILE]");
  command->add_flag(
      "--complete", options->complete,
      "of a folder: digitize the photographs that were never digitized, and keep the results in it");
  command->add_option(
      "--rig", options->reading.rig_path,
      "rig file (default: those that the session keeps, or rig.toml beside the log, else the example "
      "that comes with strobe)");
  command->add_option(
      "--key-file", options->reading.key_file,
      "the lab's key, to know the lab's messages (default: as `strobe key` tells); a log without "
      "its seal is shown as unverified");
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->footer(
      "Examples: strobe replay run1 --json\n"
      "          strobe replay run1 --complete --results\n"
      "          strobe replay run1/host-20260131T093000Z.lcmlog --json");
  command_line::for_experts(*command, {"--key-file"});
  command->callback([options, &exit_status] { exit_status = run_replay(*options); });
}

}  // namespace strobe::host
