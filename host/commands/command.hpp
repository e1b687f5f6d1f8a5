// How a subcommand of `strobe` registers itself. Each add_* function adds one subcommand to the application;
// its options live as long as the application. When the subcommand was chosen, its callback runs it and
// stores the exit status: 0 done, 1 ran but the shot or check failed, 2 bad usage or input (one line on
// stderr). Single-threaded. A new subcommand: declare it here, define it in host/commands/<name>_command.cpp,
// add it in program.cpp.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace strobe::host {

inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kBadInput = 2;

/// The command line as main() has it; returns the exit status.
int run_program(int argc, char** argv);

void add_fire_command(CLI::App& app, int& exit_status);
void add_live_command(CLI::App& app, int& exit_status);
void add_replay_command(CLI::App& app, int& exit_status);
void add_series_command(CLI::App& app, int& exit_status);
void add_shot_command(CLI::App& app, int& exit_status);
void add_reduce_command(CLI::App& app, int& exit_status);
void add_contact_command(CLI::App& app, int& exit_status);
void add_predict_command(CLI::App& app, int& exit_status);
void add_digitize_command(CLI::App& app, int& exit_status);
void add_spin_command(CLI::App& app, int& exit_status);
void add_fit_command(CLI::App& app, int& exit_status);
void add_thesis_command(CLI::App& app, int& exit_status);
void add_ball_command(CLI::App& app, int& exit_status);
void add_bounces_command(CLI::App& app, int& exit_status);
void add_protocol_command(CLI::App& app, int& exit_status);
void add_report_command(CLI::App& app, int& exit_status);
void add_camera_command(CLI::App& app, int& exit_status);
void add_calibrate_command(CLI::App& app, int& exit_status);
void add_commission_command(CLI::App& app, int& exit_status);
void add_design_command(CLI::App& app, int& exit_status);
void add_batch_command(CLI::App& app, int& exit_status);
void add_export_command(CLI::App& app, int& exit_status);
void add_compare_command(CLI::App& app, int& exit_status);
void add_bundle_command(CLI::App& app, int& exit_status);
void add_key_command(CLI::App& app, int& exit_status);

/// Who runs this program, for others who use the same rig and for the session's record: "login@machine", at
/// most 64 bytes, without blanks and control characters. Reads the system's tables; not thread-safe.
std::string operator_name();

/// As the program was started; none where the system does not tell.
std::vector<std::string> typed_command_line();

/// Prints "strobe: WHAT" as one line on stderr (line breaks within become spaces) and returns kBadInput.
int bad_input(const std::string& what);

/// Prints "strobe: WHAT" as one line on stderr and returns kFailed.
int failed(const std::string& what);

}  // namespace strobe::host
