#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/command_line/command_line.hpp"
#include "host/commands/command.hpp"

namespace strobe::host {
namespace {

/// NaN and infinity are spelled like numbers, but no option means them.
std::string finite(const std::string& text) {
  return std::isfinite(std::strtod(text.c_str(), nullptr)) ? std::string() : text + " is not a finite number";
}

void demand_finite_numbers(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands({})) {
    for (CLI::Option* option : command->get_options()) {
      if (option->get_type_name().rfind("FLOAT", 0) == 0) option->check(finite);
    }
  }
}

}  // namespace

int run_program(int argc, char** argv) {
  CLI::App app{"Strobe-photography impact experiments: fire shots, watch them, reduce frames."};
  app.name("strobe");
  command_line::set_help(app);
  app.set_version_flag("--version", STROBE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Example: strobe fire --rig rig.toml --session run1 --shots 9 --spin zero --angle 23\n"
      "Exit status: 0 done, 1 ran but the shot or check failed, 2 bad usage or input.");
  int exit_status = kDone;
  add_fire_command(app, exit_status);
  add_live_command(app, exit_status);
  add_replay_command(app, exit_status);
  add_series_command(app, exit_status);
  add_report_command(app, exit_status);
  add_protocol_command(app, exit_status);
  add_shot_command(app, exit_status);
  add_digitize_command(app, exit_status);
  add_spin_command(app, exit_status);
  add_reduce_command(app, exit_status);
  add_contact_command(app, exit_status);
  add_predict_command(app, exit_status);
  add_fit_command(app, exit_status);
  add_thesis_command(app, exit_status);
  add_ball_command(app, exit_status);
  add_bounces_command(app, exit_status);
  add_design_command(app, exit_status);
  add_camera_command(app, exit_status);
  add_calibrate_command(app, exit_status);
  add_commission_command(app, exit_status);
  add_batch_command(app, exit_status);
  add_export_command(app, exit_status);
  add_compare_command(app, exit_status);
  add_bundle_command(app, exit_status);
  add_key_command(app, exit_status);
  demand_finite_numbers(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& told) {  // help, or the version
    return app.exit(told);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "%s\n", command_line::complaint(app, error).c_str());
    return kBadInput;
  }
  return exit_status;
}

}  // namespace strobe::host
