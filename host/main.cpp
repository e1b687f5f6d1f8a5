// strobe: the host's commands.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>

#include "common/command_line/command_line.hpp"
#include "host/commands/command.hpp"
#include "host/web/http/worker.hpp"

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

int run(int argc, char** argv) {
  CLI::App app{"Strobe-photography impact experiments: fire shots, watch them, reduce frames."};
  app.name("strobe");
  strobe::command_line::set_help(app);
  app.set_version_flag("--version", STROBE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Example: strobe fire --rig rig.toml --session run1 --shots 9 --spin zero --angle 23\n"
      "Exit status: 0 done, 1 ran but the shot or check failed, 2 bad usage or input.");
  int exit_status = strobe::host::kDone;
  strobe::host::add_fire_command(app, exit_status);
  strobe::host::add_live_command(app, exit_status);
  strobe::host::add_replay_command(app, exit_status);
  strobe::host::add_series_command(app, exit_status);
  strobe::host::add_report_command(app, exit_status);
  strobe::host::add_shot_command(app, exit_status);
  strobe::host::add_digitize_command(app, exit_status);
  strobe::host::add_reduce_command(app, exit_status);
  strobe::host::add_contact_command(app, exit_status);
  strobe::host::add_predict_command(app, exit_status);
  strobe::host::add_fit_command(app, exit_status);
  strobe::host::add_thesis_command(app, exit_status);
  strobe::host::add_bounces_command(app, exit_status);
  strobe::host::add_calibrate_command(app, exit_status);
  strobe::host::add_commission_command(app, exit_status);
  strobe::host::add_batch_command(app, exit_status);
  strobe::host::add_export_command(app, exit_status);
  strobe::host::add_key_command(app, exit_status);
  demand_finite_numbers(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& told) {  // help, or the version
    return app.exit(told);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "%s\n", strobe::command_line::complaint(app, error).c_str());
    return strobe::host::kBadInput;
  }
  return exit_status;
}

/// What was printed may still be on its way to a full disk.
int finish_output(int exit_status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_status;
  const int failed = strobe::host::failed("standard output: not everything could be written");
  return exit_status == strobe::host::kDone ? failed : exit_status;
}

/// What a viewer of the page asked for may still be computed, with what ending in order would take from under
/// it.
int end(int exit_status) {
  if (strobe::web::work_left_behind()) _exit(exit_status);
  return exit_status;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told like a full disk
  try {
    return end(finish_output(run(argc, argv)));
  } catch (const std::bad_alloc&) {
    return strobe::host::failed("there is not enough memory");
  } catch (const std::exception& error) {
    return strobe::host::failed(error.what());
  }
}
