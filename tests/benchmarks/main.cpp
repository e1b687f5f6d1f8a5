// strobe-bench: measurements whose figures are taken by hand, too long or too noisy for tests.
#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>

#include "tests/benchmarks/command.hpp"

namespace {

using AddCommand = void (*)(CLI::App& app, int& exit_status);
constexpr std::array<AddCommand, 22> kCommands{
    strobe::benchmarks::add_timing_command,       strobe::benchmarks::add_spin_command,
    strobe::benchmarks::add_loop_command,         strobe::benchmarks::add_flood_command,
    strobe::studies::add_effects_command,         strobe::studies::add_efficiency_command,
    strobe::studies::add_digits_command,          strobe::studies::add_thesis_command,
    strobe::studies::add_trade_command,           strobe::studies::add_digitize_command,
    strobe::studies::add_fit_coverage_command,    strobe::studies::add_light_command,
    strobe::studies::add_series_coverage_command, strobe::studies::add_contact_command,
    strobe::studies::add_design_command,          strobe::studies::add_digitizer_noise_command,
    strobe::studies::add_board_plan_command,      strobe::studies::add_drift_command,
    strobe::studies::add_drops_command,           strobe::studies::add_protocol_risk_command,
    strobe::studies::add_bounces_study_command,   strobe::studies::add_attitude_command};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measurements of the whole product.\nExample: strobe-bench timing --rounds 3 --seconds 15"};
  app.name("strobe-bench");
  app.require_subcommand(1);
  int exit_status = 0;
  for (const AddCommand add : kCommands) add(app, exit_status);
  try {
    app.parse(argc, argv);
    return exit_status;
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "strobe-bench: %s (--help lists commands and options)\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "strobe-bench: %s\n", error.what());
    return 1;
  }
}
