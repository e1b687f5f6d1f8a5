// strobe: the host's commands.
#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "host/commands/command.hpp"

namespace {

std::string one_line(const CLI::ParseError& error) {
  const std::string what = error.what();
  return what.empty() ? error.get_name() : what;
}

int run(int argc, char** argv) {
  CLI::App app{"Strobe-photography impact experiments: fire shots, watch them, reduce frames."};
  app.name("strobe");
  app.require_subcommand(1);
  app.footer(
      "Example: strobe fire --rig rig.toml --session run1 --shots 9 --spin zero --angle 23\n"
      "Exit status: 0 done, 1 ran but the shot or check failed, 2 bad usage or input.");
  int exit_status = strobe::host::kDone;
  strobe::host::add_fire_command(app, exit_status);
  strobe::host::add_live_command(app, exit_status);
  strobe::host::add_replay_command(app, exit_status);
  strobe::host::add_reduce_command(app, exit_status);
  strobe::host::add_contact_command(app, exit_status);
  strobe::host::add_predict_command(app, exit_status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return strobe::host::bad_input(one_line(error) + " (strobe --help lists commands and options)");
  }
  return exit_status;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    return strobe::host::failed(error.what());
  }
}
