// strobe commission: a rig proves itself, step by step.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "common/command_line/command_line.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/commission_run.hpp"
#include "host/commission/record/record.hpp"
#include "host/commission/steps.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {
namespace {

struct CommissionOptions {
  CommissionRequest request;  ///< what is taken as it is given
  std::vector<std::string> only, skip;
  bool list = false;
  int times = 1;
};

Result<void> check_step(const char* option, const std::string& id) {
  const auto infos = commission::all_infos();
  if (std::ranges::find(infos, id, &commission::StepInfo::id) != infos.end()) return {};
  return fail(fmt::format("{}: there is no step {}; --list has them", option, id));
}

Result<CommissionRequest> request_of(const CommissionOptions& options) {
  CommissionRequest request = options.request;
  auto rig = load_rig(request.paths.rig_path);
  if (!rig) return tl::unexpected(rig.error());
  request.rig = std::move(*rig);
  request.rig.commission.times = options.times;
  const auto key = lab_key(request.paths, request.rig);
  if (!key) return tl::unexpected(key.error());
  request.key = *key;
  for (const std::string& id : options.only) {
    if (auto known = check_step("--only", id); !known) return tl::unexpected(known.error());
    request.only.insert(id);
  }
  if (!request.from.empty())
    if (auto known = check_step("--from", request.from); !known) return tl::unexpected(known.error());
  for (const std::string& text : options.skip) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals + 1 == text.size())
      return fail("--skip: must be STEP=REASON, such as shutter=\"no contact\", not " + text);
    if (auto known = check_step("--skip", text.substr(0, equals)); !known)
      return tl::unexpected(known.error());
    request.skip[text.substr(0, equals)] = text.substr(equals + 1);
  }
  request.record_path = commission::record_path(request.paths.rig_path, request.rig.commission).string();
  request.paths.url = lcm_url(request.paths.url, request.rig);
  if (request.session.empty()) request.session = "commission-" + utc_for_file(MachineClock().read().wall);
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
        line.step == nullptr ? "to do" : std::string(commission::in_words(line.step->result.state));
    std::string when = line.step == nullptr ? "" : line.step->utc.substr(0, 10);
    if (line.changed) when += ", before the rig file's change";
    if (line.old) when += ", too old";
    fmt::print("{:<15} {:<38} {:<14} {}\n", line.info.id, line.info.title, state, when);
  }
  return kDone;
}

int run(const CommissionOptions& options) {
  const auto request = request_of(options);
  if (!request) return bad_input("commission: " + request.error().message);
  return options.list ? list_steps(*request) : run_commission(*request);
}

void add_options(CLI::App& command, CommissionOptions& options) {
  CommissionRequest& request = options.request;
  command
      .add_option("--rig", request.paths.rig_path,
                  "rig file; the record is kept beside it: RIG.commission.jsonl")
      ->required();
  command.add_option("--session", request.session,
                     "session folder of the shots (default: commission-<UTC> in the current one)");
  command.add_flag("--list", options.list, "only show the steps and how they stand");
  command.add_option("--only", options.only, "do this step, any number of times; also if it has passed")
      ->take_all();
  command.add_option("--from", request.from, "do this step and all after it, also if they have passed");
  command.add_option("--skip", options.skip, "leave a step out: STEP=REASON, any number of times")
      ->take_all();
  command
      .add_option(
          "--times", options.times,
          "so many times as many flashes, drops and balls: for what was not told apart from its limit")
      ->check(CLI::Range(1, 20));
  command.add_option("--wait", request.wait_s, "seconds for each thing that you are to do (default 60)")
      ->check(CLI::Range(0.1, 1e6));
  command.add_flag("--yes", request.yes,
                   "for scripts: every question is answered with yes; OUTPUTS MOVE UNASKED");
  command.add_flag("--json", request.json, "one JSON object a step on standard output, nothing else there");
  add_web_options(command, request.web);
  add_photograph_options(command, request.photographs);
  add_link_options(command, request.paths);
}

}  // namespace

void add_commission_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<CommissionOptions>();
  CLI::App* command =
      app.add_subcommand("commission", "Prove a rig, step by step; each step says what to do");
  add_options(*command, *options);
  command_line::for_experts(*command, {"--effort", "--lcm-url", "--key-file", "--sessions"});
  command->footer(
      "Each step says what will move before it moves, waits for your yes, and passes or fails with a number: "
      "passed where value ± 2 sd is within the limits, failed where it is beyond one, else not told apart. "
      "Ctrl-C disarms and keeps what is done; run again, it goes on where it stopped. The page of --web "
      "shows it all, and takes confirmations of what moves nothing. A step is done again when its part of "
      "the rig file has changed.\n"
      "Example: strobe commission --rig rig.toml --session commissioning\n"
      "         strobe commission --rig rig.toml --only lamp_a --yes --json\n"
      "Exit status: 0 all passed, 1 some did not, 2 bad usage or input.");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::host
