// How a subcommand of `strobe-bench` registers itself: add_*() adds it to the program; when it was chosen its
// callback measures, prints, and stores the exit status (0 done, 1 ran but failed, 2 bad usage or input). A
// new one: declare it here, list it in tests/benchmarks/main.cpp, define it in a folder of its own here (timed
// programs) or in tests/studies (accuracy), whose CMakeLists.txt adds its sources to the program. Single-threaded.
#pragma once

namespace CLI {
class App;
}

namespace strobe::benchmarks {

void add_timing_command(CLI::App& app, int& exit_status);
void add_spin_command(CLI::App& app, int& exit_status);
void add_loop_command(CLI::App& app, int& exit_status);
void add_flood_command(CLI::App& app, int& exit_status);

}  // namespace strobe::benchmarks

namespace strobe::studies {

void add_attitude_command(CLI::App& app, int& exit_status);
void add_board_plan_command(CLI::App& app, int& exit_status);
void add_bounces_study_command(CLI::App& app, int& exit_status);
void add_contact_command(CLI::App& app, int& exit_status);
void add_design_command(CLI::App& app, int& exit_status);
void add_digitize_command(CLI::App& app, int& exit_status);
void add_digitizer_noise_command(CLI::App& app, int& exit_status);
void add_digits_command(CLI::App& app, int& exit_status);
void add_drift_command(CLI::App& app, int& exit_status);
void add_drops_command(CLI::App& app, int& exit_status);
void add_efficiency_command(CLI::App& app, int& exit_status);
void add_fit_coverage_command(CLI::App& app, int& exit_status);
void add_effects_command(CLI::App& app, int& exit_status);
void add_light_command(CLI::App& app, int& exit_status);
void add_protocol_risk_command(CLI::App& app, int& exit_status);
void add_series_coverage_command(CLI::App& app, int& exit_status);
void add_thesis_command(CLI::App& app, int& exit_status);
void add_trade_command(CLI::App& app, int& exit_status);

}  // namespace strobe::studies
