// The subcommands of strobe-sim. Each prints its errors on stderr, one line each, and returns the exit
// status: 0 done, 1 ran but failed, 2 bad usage or input.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "sim/gpiochip/state.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

/// The command line as main() has it; returns the exit status.
int run_program(int argc, char** argv);

/// Prints "strobe-sim: message" on stderr and returns the status.
int report_error(const std::string& message, int status);

struct RunOptions {
  std::string scene;
  std::optional<std::uint64_t> seed;  ///< absent: a random one, printed
  std::string lcm_url;
  std::string key_file;  ///< of the lab; empty: where strobe looks for it
  std::string rig_name = "bench";
  std::string chip_dir;        ///< empty: a temporary folder
  std::string truth_file;      ///< empty: none
  std::string changes_file;    ///< empty: none
  bool gev_camera = false;     ///< a GigE Vision device in place of the folder
  bool ptp_camera = false;     ///< one that speaks PTP/IP
  std::string camera_address;  ///< its
  bool sequencer = false;      ///< a flash sequencer in place of the chip
  std::string photographs;     ///< folder for the camera's files; empty: none are made
  std::string rig_file;        ///< to write before the command starts; empty: none
  bool digitizer = true;
  gpio::Pace pace = gpio::Pace::wall;
  std::optional<std::int64_t> clock_start_s;  ///< of rig time: a run that repeats to the byte
  std::string tolerance;                      ///< empty: none
  std::vector<std::string> command;
};
/// Exit status of the command; 128 plus the signal that ended it.
int run_command(const RunOptions& options);

/// Becomes the command, in the time of the rig whose chip is in that folder.
int join_command(const std::string& chip_dir, const std::vector<std::string>& command);

constexpr double kLongestSuspension_s = 30.0 * 86'400.0;
struct ClockOptions {
  double suspend_s = 0.0;
  double step_s = 0.0;
};
/// Of a rig that keeps a time of its own; `after`: LINE=N, or empty.
int clock_command(const std::string& chip_dir, const ClockOptions& options, const std::string& after);

/// Of simulated shots.
struct SimulatedOptions {
  std::string scene;
  int shots = 1;
  std::uint64_t seed = 1;
  double period_ms = 3.0;
  double exposure_ms = 0.0;  ///< 0: as long as the balls take to cross the view

  /// Period and exposure, both below 1e12 ms.
  ShootSettings settings() const {
    return {.period = nanoseconds(std::llround(period_ms * 1e6)),
            .exposure = nanoseconds(std::llround(exposure_ms * 1e6))};
  }
};
/// Fails, naming the option, for settings out of range.
Result<Shooter> make_shooter(const SimulatedOptions& options, const Scene& scene, const Model& model,
                             const ShootSettings& settings);

struct ShootOptions : SimulatedOptions {
  std::string model = "full";
  std::string tolerance;  ///< empty: none
  bool perfect_digitizer = false;
  std::string truth_file;  ///< empty: none
};
/// Prints the frames of simulated shots, one per line.
int shoot_command(const ShootOptions& options);

struct EffectsOptions : SimulatedOptions {
  std::string tolerance;  ///< empty: the scene's own
  bool json = false;
};
/// Prints which effects a scene needs at a tolerance, and what that saves.
int effects_command(const EffectsOptions& options);

struct PhotographOptions : SimulatedOptions {
  std::string folder;
  std::optional<PhotographFormat> format;  ///< in place of the scene's
  bool json = false;
};
/// Writes photographs of simulated shots, and the truth about them.
int photograph_command(const PhotographOptions& options);

struct BoardOptions {
  std::string folder;
  std::string scene;  ///< whose camera sees the board; empty: that of the options below
  std::string board = "chessboard";
  int columns = 9, rows = 6;
  double spacing_mm = 20.0;
  int width_px = 2592, height_px = 2048;
  double focal_px = 5200.0;
  std::vector<double> lens{0.0, 0.0, 0.0, 0.0};
  double distance_m = 1.0;
  int slanted = 0;
  std::uint64_t seed = 1;
  bool json = false;
};
/// Writes photographs of a calibration board, and the truth about them.
int board_command(const BoardOptions& options);

/// The model that a tolerance as typed allows (empty: full), printed on stderr. 0, or the exit status after
/// the message.
int choose_model(const std::string& tolerance, const Scene& scene, const ShootSettings& settings,
                 Model& model);

int scenes_command(bool json);

/// `drives`: LINE=LEVEL or LINE=open, LINE a name or an offset. At once, or after the N-th rising edge of a
/// line
/// (`after` is LINE=N).
int drive_command(const std::string& chip_dir, const std::vector<std::string>& drives,
                  const std::string& after);
int lines_command(const std::string& chip_dir, bool json);

/// Runs a command, and turns the key, presses the e-stop and pulls wires of the chip as it asks for on
/// standard error (the words of `strobe commission`), which is passed on. Its exit status is, too.
int operator_command(const std::string& chip_dir, const std::vector<std::string>& command);

/// Unplugs the chip: at once, or after the N-th rising edge of a line (`after` is LINE=N).
int unplug_command(const std::string& chip_dir, const std::string& after);

/// Derives the scenes of the thesis's conditions from its tables and writes them to a folder.
int fit_command(const std::string& tables, const std::string& folder, bool json);

}  // namespace strobe::sim
