// strobe commission: a rig proves itself, step by step.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "common/authentication/key_file.hpp"
#include "common/command_line/help.hpp"
#include "common/wire/lcm_url.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/commission_run.hpp"
#include "host/commands/photograph_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/commission/all_steps.hpp"
#include "host/commission/record/record.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {
namespace {

struct CommissionOptions {
  std::string rig_path, session, url, key_file, from;
  std::vector<std::string> only, skip;
  PhotographOptions photographs;
  WebOptions web;
  double wait_s = 60.0;
  bool yes = false, json = false, list = false;
};

Result<void> check_step(const char* option, const std::string& id) {
  const auto infos = commission::all_infos();
  if (std::ranges::find(infos, id, &commission::StepInfo::id) != infos.end()) return {};
  return fail(fmt::format("{}: there is no step {}; --list has them", option, id));
}

Result<CommissionRequest> request_of(const CommissionOptions& options) {
  auto rig = load_rig(options.rig_path);
  if (!rig) return tl::unexpected(rig.error());
  const auto key = authentication::find_key({options.key_file, rig->key_file.value_or("")});
  if (!key) return tl::unexpected(key.error());
  CommissionRequest request(key->key);
  for (const std::string& id : options.only) {
    if (auto known = check_step("--only", id); !known) return tl::unexpected(known.error());
    request.only.insert(id);
  }
  if (!options.from.empty())
    if (auto known = check_step("--from", options.from); !known) return tl::unexpected(known.error());
  request.from = options.from;
  for (const std::string& text : options.skip) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals + 1 == text.size())
      return fail("--skip: wants STEP=REASON, as shutter=\"no contact\", not " + text);
    if (auto known = check_step("--skip", text.substr(0, equals)); !known)
      return tl::unexpected(known.error());
    request.skip[text.substr(0, equals)] = text.substr(equals + 1);
  }
  request.rig_path = options.rig_path;
  request.record_path = commission::record_path(options.rig_path, rig->commission).string();
  request.url = lcm_url(options.url, *rig);
  request.session =
      options.session.empty() ? "commission-" + utc_for_file(MachineClock().read().wall) : options.session;
  request.rig = std::move(*rig);
  request.photographs = options.photographs;
  request.key_file = options.key_file;
  request.web = options.web;
  request.wait_s = options.wait_s;
  request.yes = options.yes;
  request.json = options.json;
  return request;
}

/// The steps and how they stand; moves nothing, listens to nothing.
int list_steps(const CommissionRequest& request) {
  const auto record = commission::read_record(request.record_path);
  if (!record) return bad_input(record.error().message);
  const auto stands =
      commission::standing(*record, commission::all_infos(), request.rig, MachineClock().read().wall);
  for (const auto& line : stands.lines) {
    std::string state =
        line.step == nullptr ? "to do" : std::string(commission::name(line.step->result.state));
    std::string when = line.step == nullptr ? "" : line.step->utc.substr(0, 10);
    if (line.changed) when += ", before the rig file's change";
    if (line.old) when += ", too old";
    fmt::print("{:<15} {:<38} {:<8} {}\n", line.info.id, line.info.title, state, when);
  }
  return kDone;
}

int run(const CommissionOptions& options) {
  const auto request = request_of(options);
  if (!request) return bad_input("commission: " + request.error().message);
  return options.list ? list_steps(*request) : run_commission(*request);
}

void add_options(CLI::App& command, CommissionOptions& options) {
  command
      .add_option("--rig", options.rig_path, "rig file; the record is kept beside it: RIG.commission.jsonl")
      ->required();
  command.add_option("--session", options.session,
                     "session folder of the shots (default: commission-<UTC> in the current one)");
  command.add_flag("--list", options.list, "only show the steps and how they stand");
  command.add_option("--only", options.only, "do this step, any number of times; also if it has passed")
      ->take_all();
  command.add_option("--from", options.from, "do this step and all after it, also if they have passed");
  command.add_option("--skip", options.skip, "leave a step out: STEP=REASON, any number of times")
      ->take_all();
  command.add_option("--wait", options.wait_s, "seconds for each thing that you are to do (default 60)")
      ->check(CLI::Range(0.1, 1e6));
  command.add_flag("--yes", options.yes,
                   "for scripts: every question is answered with yes; OUTPUTS MOVE UNASKED");
  command.add_flag("--json", options.json, "one JSON object a step on standard output, nothing else there");
  add_web_options(command, options.web);
  add_photograph_options(command, options.photographs);
  command.add_option("--lcm-url", options.url, "LCM URL (default: the rig file's, else this machine only)")
      ->check(wire::lcm_url_problem);
  command.add_option("--key-file", options.key_file,
                     "the lab's key (default: the rig file's, $STROBE_KEY_FILE, ~/.config/strobe/lab.key)");
}

}  // namespace

void add_commission_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<CommissionOptions>();
  CLI::App* command =
      app.add_subcommand("commission", "Prove a rig, step by step; each step says what to do");
  add_options(*command, *options);
  command_line::for_experts(*command, {"--effort", "--lcm-url", "--key-file", "--sessions", "--web-files"});
  command->footer(
      "Each step says what will move before it moves, waits for your yes, and passes or fails with a number. "
      "Ctrl-C disarms and keeps what is done; run again, it goes on where it stopped. The page of --web "
      "shows it all, and takes confirmations of what moves nothing. A step is done again "
      "when "
      "its part of the rig file has changed.\n"
      "Example: strobe commission --rig rig.toml --session commissioning\n"
      "         strobe commission --rig rig.toml --only lamp_a --yes --json\n"
      "Exit status: 0 all passed, 1 some did not, 2 bad usage or input.");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::host
