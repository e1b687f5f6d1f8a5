#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "common/data/thesis_data.hpp"
#include "common/authentication/key_file.hpp"
#include "common/command_line/help.hpp"
#include "common/config/default_rig.hpp"
#include "common/config/files.hpp"
#include "common/wire/lcm_url.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/fire_options.hpp"
#include "host/commands/fire_run.hpp"
#include "host/commands/operator_name.hpp"
#include "host/commands/photograph_options.hpp"
#include "host/messages/command_factory.hpp"
#include "host/session/former_runs.hpp"
#include "host/session/run_lock.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {
namespace {

/// What strobed would refuse, once armed.
Result<void> check_plan(const FireOptions& options, const FireRequest& request) {
  const auto problem = plan_problem(request.series.plan, request.rig.limits);
  if (!problem) return {};
  const std::string rig = options.rig_path.empty() ? "the example rig file" : options.rig_path;
  const std::string where = options.plan_path.empty() ? rig + ": plan." : options.plan_path + ": ";
  return fail(fmt::format("{}{}: {} (by the limits in {})", where, problem->field, problem->what, rig));
}

/// The plan to be fired, and the text of which the session keeps a copy.
Result<void> set_plan(const FireOptions& options, FireRequest& request) {
  PlanFile plan = request.rig.plan;
  if (!options.plan_path.empty()) {
    const auto text = config::read_file(options.plan_path);
    if (!text) return tl::unexpected(text.error());
    auto read = read_plan(*text, options.plan_path, plan);
    if (!read) return tl::unexpected(read.error());
    plan = std::move(*read);
    request.plan_text = *text;
  }
  if (!options.spacing.empty()) {
    if (plan.coded()) return fail("--spacing: the plan has a code of its own");
    plan.spacing = options.spacing == "coded" ? Spacing::coded : Spacing::even;
  }
  // Who asks for the code by name measures the photographs with the digitizer, be it later.
  const bool digitized = !options.photographs.folder.empty() || request.rig.camera.folder.has_value() ||
                         options.spacing == "coded";
  SpacedPlan spaced = spaced_plan(plan, request.rig, digitized);
  if (options.plan_path.empty()) request.plan_text = plan_to_toml(spaced.plan);
  request.series.plan = spaced.plan.shot();
  request.series.plan.dry = options.dry;
  request.train_remark = std::move(spaced.remark);
  return check_plan(options, request);
}

std::string absolute(const std::string& path) {
  std::error_code error;
  return path.empty() ? "" : std::filesystem::absolute(path, error).string();
}

/// What the session keeps of it.
RunRecord record_of(const FireOptions& options, const FireRequest& request) {
  RunRecord run;
  run.version = STROBE_VERSION;
  run.operator_name = operator_name();
  run.shots = request.series.shots;
  run.until = request.series.whole_session;
  run.retries = request.series.retries;
  run.dry = options.dry;
  run.notes = request.series.notes;
  if (!options.plan_path.empty()) run.spacing = options.spacing;
  run.rig_file = absolute(options.rig_path);
  run.photographs = absolute(options.photographs.folder);
  run.effort = options.photographs.effort;
  run.key_fingerprint = request.key.fingerprint();
  run.command = options.command;
  return run;
}

/// How many shots, those included that the session holds already.
Result<void> set_shots(const FireOptions& options, FireRequest& request) {
  ShotSeriesSettings& series = request.series;
  series.whole_session = options.until.has_value();
  if (series.whole_session) {
    const auto rows = read_result_rows(request.session);
    if (!rows) return tl::unexpected(rows.error());
    for (const auto& [key, counts] : *rows) series.counted += counts ? 1 : 0;
  }
  series.shots = options.until ? *options.until : options.shots.value_or(1);
  series.retries = options.retries.value_or(std::max(0, series.shots - series.counted));
  return {};
}

Result<FireRequest> request_of(const FireOptions& options) {
  auto rig = load_rig(options.rig_path);
  if (!rig) return tl::unexpected(rig.error());
  const auto key = authentication::find_key({options.key_file, rig->key_file.value_or("")});
  if (!key) return tl::unexpected(key.error());
  FireRequest request(key->key);
  request.rig = std::move(*rig);
  request.rig_remark = config::words_on_example(options.rig_path, "--rig");
  if (auto set = set_plan(options, request); !set) return tl::unexpected(set.error());
  auto notes = notes_of(options);
  if (!notes) return tl::unexpected(notes.error());
  request.series.notes = std::move(*notes);
  // Plan and notes travel in one command.
  const auto sealed = CommandSealer(request.key, request.rig.rig)
                          .seal(CommandFactory(1).fire(1, 1, request.series.plan, request.series.notes));
  if (!sealed) return tl::unexpected(sealed.error());
  request.series.blocked_timeout_s = options.wait_s;
  request.series.photograph_timeout_s = request.rig.analysis.photograph_timeout_s;
  request.series.clear_fault = options.clear_fault;
  request.url = lcm_url(options.url, request.rig);
  request.session =
      options.session.empty() ? "session-" + utc_for_file(MachineClock().read().wall) : options.session;
  // From here on nobody else writes there.
  auto lock = RunLock::of_session(request.session, operator_name(), MachineClock().read().wall);
  if (!lock) return tl::unexpected(lock.error());
  request.lock.emplace(std::move(*lock));
  if (auto set = set_shots(options, request); !set) return tl::unexpected(set.error());
  request.photographs = options.photographs;
  request.run = record_of(options, request);
  if (options.angle_deg) request.condition = thesis::shipped_condition(options.spin, *options.angle_deg);
  request.style = Terminal::style(options.json, options.plain);
  request.all = options.all;
  request.web = options.web;
  request.key_file = options.key_file;
  return request;
}

int run(const FireOptions& given) {
  const HostReading asked = MachineClock().read();
  if (given.until && given.dry) return bad_input("--until counts shots with a ball: not with --dry");
  const auto options = given.resume ? resumed(given) : Result<FireOptions>(given);
  if (!options) return bad_input(options.error().message);
  auto request = request_of(*options);  // which holds the session until it ends
  if (!request) return bad_input(request.error().message);
  request->asked = asked;
  return run_fire(*request);
}

}  // namespace

void add_fire_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<FireOptions>();
  CLI::App* command =
      app.add_subcommand("fire", "Fire shots and show the rebound of each; rejected shots are fired again");
  CLI::Option* const shots =
      command->add_option("--shots", options->shots, "shots that must count (default 1)")
          ->check(CLI::Range(1, 100000));
  command
      ->add_option("--until", options->until,
                   "fire until the session holds so many shots that count, those of earlier runs included")
      ->check(CLI::Range(1, 100000))
      ->excludes(shots);
  command->add_flag("--resume", options->resume,
                    "go on with what the session's last run was asked for: shots, plan, labels, notes");
  command
      ->add_option("--retries", options->retries,
                   "shots that may be fired again, in all (default: as many as --shots)")
      ->check(CLI::Range(0, 100000));
  command->add_option("--rig", options->rig_path, "rig file (default: the example that comes with strobe)");
  command->add_option("--session", options->session,
                      "session folder (default: session-<UTC> in the current one)");
  command->add_option("--plan", options->plan_path, "shot plan, TOML (default: the rig file's [plan])");
  command
      ->add_option(
          "--spacing", options->spacing,
          "even: all intervals between flashes are the plan's period; coded: some are longer, so that images "
          "measured by the digitizer tell which flashes made them (default: the plan's; without photographs "
          "even)")
      ->check(CLI::IsMember({"even", "coded"}));
  command->add_option("--spin", options->spin, "label of the series: zero, top or back")
      ->check(CLI::IsMember({"zero", "top", "back"}));
  command->add_option("--angle", options->angle_deg, "label of the series: the machine's angle in degrees")
      ->check(CLI::Range(-90.0, 90.0));
  command->add_option("--note", options->notes, "record entry key=value, any number of times")->take_all();
  command->add_flag("--dry", options->dry, "lamps and shutter only; reports the flashes' timing");
  command->add_flag("--clear-fault", options->clear_fault, "clear a fault that the firmware has latched");
  command->add_option("--wait", options->wait_s, "seconds to wait while the rig cannot be armed (default 60)")
      ->check(CLI::Range(0.1, 1e6));
  add_photograph_options(*command, options->photographs);
  command->add_option("--lcm-url", options->url, "LCM URL (default: the rig file's, else this machine only)")
      ->check(wire::lcm_url_problem);
  command->add_option("--key-file", options->key_file,
                      "the lab's key (default: the rig file's, $STROBE_KEY_FILE, ~/.config/strobe/lab.key)");
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->add_flag("--plain", options->plain, "lines of text instead of a screen");
  command->add_flag("--all", options->all, kAllHelp);
  add_web_options(*command, options->web);
  command_line::for_experts(*command, {"--spacing", "--effort", "--lcm-url", "--key-file", "--wait",
                                       "--clear-fault", "--all", "--sessions", "--web-files"});
  command->footer(
      "Ctrl-C finishes the shot under way and ends; a second one aborts it. Ctrl-\\ aborts it at once.\n"
      "Example: strobe fire --rig rig.toml --session run1 --shots 9 --spin zero --angle 23 --note "
      "operator=\"A. Author\"\n"
      "         strobe fire --session run1 --resume --web\n"
      "Exit status: 0 all shots counted, 1 some did not, 2 bad usage or input.");
  command->callback([options, &exit_status] {
    options->command = words_of_command_line();
    exit_status = run(*options);
  });
}

}  // namespace strobe::host
