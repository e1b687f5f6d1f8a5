#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>

#include "common/authentication/key_file.hpp"
#include "common/command_line/command_line.hpp"
#include "common/config/default_rig.hpp"
#include "common/config/files.hpp"
#include "common/data/thesis_data.hpp"
#include "common/messages/record.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/fire_run.hpp"
#include "host/commands/protocol_run.hpp"
#include "host/config/notes.hpp"
#include "host/design/promise.hpp"
#include "host/messages/command_factory.hpp"
#include "host/protocol/session_protocol.hpp"
#include "host/series/select.hpp"
#include "host/session/former_runs.hpp"
#include "host/session/run_lock.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

/// At most, where it is not said.
constexpr int kShotsUntilKnown = 100;

/// What strobed would refuse, once armed.
Result<void> check_plan(const FireOptions& options, const FireRequest& request) {
  const auto problem = plan_problem(request.series.plan, request.rig.limits);
  if (!problem) return {};
  const std::string rig = options.paths.rig_path.empty() ? "the example rig file" : options.paths.rig_path;
  const std::string where = options.plan_path.empty() ? rig + ": plan." : options.plan_path + ": ";
  return fail(fmt::format("{}{}: {} (by the limits in {})", where, problem->field, problem->what, rig));
}

/// --spin, --angle and --note. Fails, naming the option.
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

/// Of a text with commas.
std::vector<std::string> comma_separated(const std::string& text) {
  std::vector<std::string> items;
  std::istringstream in(text);
  for (std::string item; std::getline(in, item, ',');) items.push_back(item);
  return items;
}

/// The options with which the session's last run is gone on with: what it was asked for, and from the given
/// ones how. Reads the session's folder. Fails where there is no such run.
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
  FireOptions options = given;
  options.shots.reset();
  if (last.protocol.empty()) options.until = last.session_shots;
  options.protocol = last.protocol;
  options.protocol_seed = last.protocol_seed;
  options.plan_path = (folder / last.plan_file).string();
  options.spacing = last.spacing;
  options.until_known = comma_separated(last.until_known);
  if (!options.retries) options.retries = last.retries;
  if (options.paths.rig_path.empty()) options.paths.rig_path = last.rig_file;
  if (options.photographs.folder.empty()) options.photographs.folder = last.photographs;
  if (options.photographs.effort == PhotographOptions{}.effort && !last.effort.empty())
    options.photographs.effort = last.effort;
  set_labels(last, options);
  return options;
}

/// The plan to be fired, and the text of which the session keeps a copy.
Result<void> set_plan(const FireOptions& options, FireRequest& request) {
  PlanFile plan = request.rig.plan;
  if (!options.plan_path.empty()) {
    const auto text = read_option_file("--plan", options.plan_path);
    if (!text) return tl::unexpected(text.error());
    auto read = read_plan(*text, options.plan_path, plan);
    if (!read) return tl::unexpected(read.error());
    plan = std::move(*read);
    request.plan_text = *text;
  }
  if (options.drop_height_m > 0.0 && plan.drop_height_m == 0.0) {
    plan.drop_height_m = options.drop_height_m;
    plan.period_stated = !options.plan_path.empty() && plan.period_stated;
  }
  if (!options.spacing.empty()) {
    if (plan.coded())
      return fail(
          "--spacing: must not be given: the plan has its own code (intervals_us, omit, only_a, only_b)");
    plan.spacing = options.spacing == "coded" ? Spacing::coded : Spacing::even;
  }
  // Who asks for the code by name measures the photographs with the digitizer, be it later.
  const bool digitized = !options.photographs.folder.empty() || request.rig.camera.folder.has_value() ||
                         request.rig.camera.connection.kind != CameraKind::folder ||
                         options.spacing == "coded";
  SpacedPlan spaced = spaced_plan(plan, request.rig, digitized);
  if (!spaced.problem.empty())
    return fail((options.plan_path.empty() ? "the rig file's plan." : options.plan_path + ": ") +
                spaced.problem);
  if (options.plan_path.empty()) request.plan_text = plan_to_toml(spaced.plan);
  request.series.plan = spaced.plan.shot();
  request.series.plan.dry = options.dry;
  request.train_remark = std::move(spaced.remark);
  return check_plan(options, request);
}

std::string absolute(const std::string& path) {
  std::error_code error;
  return path.empty() ? "" : fs::absolute(path, error).string();
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
  run.rig_file = absolute(options.paths.rig_path);
  run.photographs = absolute(options.photographs.folder);
  run.effort = options.photographs.effort;
  run.key_fingerprint = request.key.fingerprint();
  run.command = typed_command_line();
  run.until_known = wanted_text(request.wanted);
  run.protocol = options.protocol;
  run.protocol_seed = options.protocol_seed;
  return run;
}

/// How many shots, those included that the session holds already.
Result<void> set_shots(const FireOptions& options, FireRequest& request) {
  ShotSeriesSettings& series = request.series;
  series.whole_session = options.until.has_value();
  if (series.whole_session) {
    const auto rows = read_result_rows(request.options.session);
    if (!rows) return tl::unexpected(rows.error());
    for (const auto& [key, counts] : *rows) series.counted += counts ? 1 : 0;
  }
  series.at_most = !request.wanted.empty();
  const int otherwise = series.at_most ? kShotsUntilKnown : 1;
  series.shots = options.until ? *options.until : options.shots.value_or(otherwise);
  series.retries = options.retries.value_or(std::max(0, series.shots - series.counted));
  return {};
}

/// What is to be known, and the shots of earlier runs that tell of it.
Result<void> set_wanted(const FireOptions& options, FireRequest& request) {
  auto wanted = parse_wanted("--until-known", options.until_known, Percent::allowed);
  if (!wanted) return tl::unexpected(wanted.error());
  request.wanted = std::move(*wanted);
  if (request.wanted.empty()) return {};
  const auto rows = read_result_rows(request.options.session);
  if (!rows) return tl::unexpected(rows.error());
  if (rows->empty()) return {};
  const auto session = read_session(request.options.session,
                                    {"", options.paths.key_file, reading_notes(request.options.session)});
  if (!session) return tl::unexpected(session.error());
  request.earlier = series_shots(*session, "");
  return {};
}

/// The session keeps what was promised of it.
Result<void> keep_design(const std::string& path, const std::string& session) {
  if (path.empty()) return {};
  const auto text = read_option_file("--design", path);
  if (!text) return tl::unexpected(text.error());
  if (const auto promise = parse_promise(*text, path); !promise)
    return fail("--design: " + promise.error().message);
  return config::write_file(fs::path(session) / kDesignFile, *text);
}

Result<FireRequest> request_of(const FireOptions& options) {
  auto rig = load_rig(options.paths.rig_path);
  if (!rig) return tl::unexpected(rig.error());
  const auto key = lab_key(options.paths, *rig);
  if (!key) return tl::unexpected(key.error());
  FireRequest request(options, *key);
  request.rig = std::move(*rig);
  request.rig_remark = config::example_remark(options.paths.rig_path, "--rig");
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
  request.options.paths.url = lcm_url(options.paths.url, request.rig);
  std::string& session = request.options.session;
  if (session.empty()) session = "session-" + utc_for_file(MachineClock().read().wall);
  // From here on nobody else writes there.
  auto lock = RunLock::of_session(session, operator_name(), MachineClock().read().wall);
  if (!lock) return tl::unexpected(lock.error());
  request.lock.emplace(std::move(*lock));
  if (auto kept = keep_design(options.design_path, session); !kept) return tl::unexpected(kept.error());
  if (!options.protocol.empty()) {
    const auto kept = config::write_file(fs::path(session) / protocol::kProtocolFile, options.protocol_text);
    if (!kept) return tl::unexpected(kept.error());
  }
  if (auto set = set_wanted(options, request); !set) return tl::unexpected(set.error());
  if (auto set = set_shots(options, request); !set) return tl::unexpected(set.error());
  request.run = record_of(options, request);
  if (options.angle_deg) request.condition = thesis::shipped_condition(options.spin, *options.angle_deg);
  request.style = Terminal::style(options.json, options.plain);
  return request;
}

/// One series.
int fire(const FireOptions& options, const HostReading& asked) {
  auto request = request_of(options);  // which holds the session until it ends
  if (!request) return bad_input(request.error().message);
  request->asked = asked;
  return run_fire(*request);
}

int run(const FireOptions& given) {
  const HostReading asked = MachineClock().read();
  if (given.until && given.dry) return bad_input("--until counts shots with a ball: not with --dry");
  if (!given.until_known.empty() && given.dry)
    return bad_input("--until-known needs shots with a ball: not with --dry");
  // Before anything is made or read.
  if (const auto wanted = parse_wanted("--until-known", given.until_known, Percent::allowed); !wanted)
    return bad_input(wanted.error().message);
  const auto options = given.resume ? resumed(given) : Result<FireOptions>(given);
  if (!options) return bad_input(options.error().message);
  return options->protocol.empty() ? fire(*options, asked) : run_protocol(*options, asked, fire);
}

}  // namespace

void add_fire_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<FireOptions>();
  CLI::App* command = app.add_subcommand("fire", "Fire shots, show each rebound; by a test protocol, too");
  CLI::Option* const shots =
      command->add_option("--shots", options->shots, "shots that must count (default 1)")
          ->check(CLI::Range(1, 100000));
  command
      ->add_option("--until", options->until,
                   "fire until the session holds this many shots that count, those of earlier runs included")
      ->check(CLI::Range(1, 100000))
      ->excludes(shots);
  command
      ->add_option("--until-known", options->until_known,
                   "fire until the 95 % interval of each mean is this short, as e:0.003,omega_lo:1% (half "
                   "width); at most --shots or --until (default: at most 100)")
      ->delimiter(',')
      ->allow_extra_args(false);
  CLI::Option* const protocol =
      command->add_option("--protocol", options->protocol,
                          "fire what this test protocol asks for: a name (strobe protocol list) or a file");
  command->add_option("--seed", options->protocol_seed, "of a protocol's drawn order of balls")
      ->check(CLI::Range(0, 2147483647));
  command->add_flag("--no-pause", options->no_pause,
                    "do not wait for a person between a protocol's balls and positions: nobody changes them");
  CLI::Option* const resume =
      command->add_flag("--resume", options->resume,
                        "go on with what the session's last run was asked for: shots, plan, labels, notes");
  command
      ->add_option("--retries", options->retries,
                   "shots that may be fired again, in all (default: as many as --shots)")
      ->check(CLI::Range(0, 100000));
  command->add_option("--rig", options->paths.rig_path,
                      "rig file (default: the example that comes with strobe)");
  command->add_option("--session", options->session,
                      "session folder (default: session-<UTC> in the current one)");
  command->add_option("--plan", options->plan_path, "shot plan, TOML (default: the rig file's [plan])");
  command->add_option("--design", options->design_path,
                      "what `strobe design --json` printed: series and report show what became of it");
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
  add_link_options(*command, options->paths);
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->add_flag("--plain", options->plain, "lines of text instead of a screen");
  command->add_flag("--all", options->all, kAllHelp);
  add_web_options(*command, options->web);
  for (const char* const asked :
       {"--shots", "--until", "--until-known", "--spin", "--angle", "--note", "--plan", "--spacing", "--dry"})
    resume->excludes(command->get_option(asked));
  for (const char* const asked : {"--shots", "--until", "--until-known", "--retries", "--dry"})
    protocol->excludes(command->get_option(asked));
  command_line::for_experts(
      *command, {"--seed", "--no-pause", "--retries", "--design", "--spacing", "--effort", "--lcm-url",
                 "--key-file", "--wait", "--clear-fault", "--all", "--sessions"});
  command->footer(
      "Ctrl-C finishes the shot under way and ends; a second one aborts it. Ctrl-\\ aborts it at once.\n"
      "Example: strobe fire --rig rig.toml --session run1 --shots 9 --spin zero --angle 23 --note "
      "operator=\"A. Author\"\n"
      "         strobe fire --session run1 --until-known e:0.003 --rig rig.toml\n"
      "         strobe fire --session run1 --resume --web\n"
      "Exit status: 0 all shots counted, 1 some did not, 2 bad usage or input.");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::host
