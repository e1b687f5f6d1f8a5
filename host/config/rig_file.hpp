// The host's part of the rig file: rig, lcm_url, [commands], [ball], [analysis], [camera], [record],
// [laboratory], [report], [commission], [plan], the movers' lags, and what limits a plan. The rest is
// strobed's and accepted unread. Values; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/toml_reader.hpp"
#include "common/data/ball_kind.hpp"
#include "common/flight/gravity.hpp"
#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "common/shot/plan_check.hpp"
#include "host/config/camera_table.hpp"
#include "host/config/notes.hpp"
#include "host/config/plan_file.hpp"

namespace strobe::host {

/// [commission]: what `strobe commission` holds a rig against, and how long its record is good. Each field is
/// a key of that name.
struct CommissionTable {
  /// Where the record is kept, beside the rig file unless it begins with /; absent: RIG.commission.jsonl for
  /// RIG.toml.
  std::optional<std::string> record;
  double max_age_days = 90.0;  ///< 0.01 to 100,000; reports and `strobe fire` tell of an older record

  double delay_tolerance_us = 3.0;    ///< 0.1 to 1000; of a lamp's mean delay about the rig file's
  double jitter_limit_us = 5.0;       ///< 0.1 to 1000; sd of a lamp's delay from flash to flash
  double skew_limit_us = 5.0;         ///< 0.1 to 1000; mean of A - B where both flash
  double shutter_tolerance_ms = 3.0;  ///< 0.1 to 1000; of its mean lag about the rig file's

  double brightness_ratio = 1.5;  ///< 1.01 to 100; of the brighter lamp on the picture to the dimmer one
  int balls = 9;                  ///< 2 to 1000; thrown for noise, scale and repeatability
  int times = 1;                  ///< not of the file: so many times the trains, drops and balls
  /// Where photographs of a printed chessboard are put, beside the rig file unless it begins with /; absent:
  /// nowhere.
  std::optional<std::string> board_folder;
  int board_columns = 9;          ///< 3 to 100; inner corners
  int board_rows = 6;             ///< 3 to 100
  double board_spacing_mm = 0.0;  ///< 0.1 to 1000; side of a square; 0 (key absent): not known
  double gravity_mps2 = flight::kStandardGravity_mps2;  ///< 9.7 to 9.9; the place's own
};

/// [ball]. What is absent is that of its kind, and without one as said here.
struct BallSettings {
  std::string kind_name;  ///< key kind: a shipped kind, or a path that ends in .toml
  std::optional<balls::Kind> kind;
  double diameter_m = 0.0651;      ///< 0.01 to 1
  double diameter_sd_m = 0.0008;   ///< 0 to 0.1; the diameter's tolerance as a standard deviation
  std::optional<double> mass_kg;   ///< 0.001 to 10; absent: the thesis's
  std::optional<double> alpha;     ///< inertia over m R^2, 0.01 to 2/3; absent: as measured on tennis balls
  std::optional<double> alpha_sd;  ///< 0 to 2/3; absent: as balls differ
  std::optional<double> fastest_spin_radps;  ///< 1 to 1e6, before the bounce; absent: not known
  bool line =
      true;  ///< whether one is drawn around it, to measure spin by; absent: as the kind's marking says

  ball::Ball ball() const {
    return {diameter_m, mass_kg.value_or(ball::kThesisMass_kg), alpha.value_or(ball::kMeasuredAlpha)};
  }
  flight::AirLaw air_law() const { return kind ? kind->air : flight::AirLaw{}; }
};

struct AnalysisSettings {
  std::optional<double> surface_angle_deg;  ///< -60 to 60; absent: the record's surface_angle_deg, else 0
  double photograph_timeout_s = 5.0;        ///< 0.01 to 86,400, after the shot's end
  std::optional<double> px_per_m;           ///< calibrated scale; absent: the frame's, else from the ball
  std::optional<double> px_per_m_sd;
  std::optional<double> gate_distance_m;  ///< light gate to the point of touchdown, along the ball's path
  double gate_distance_sd_m = 0.05;
  /// 0.01 to 100 us, key flash_time_sd_us; of a flash's time as its sensors give it. Absent: each shot's own,
  /// see host/assembly/flash_times.hpp.
  std::optional<double> flash_time_sd_s;
  /// 0.01 to 1000 ms, key machine_lag_sd_ms; of the machine's lag from shot to shot. Absent: not known.
  std::optional<double> machine_lag_sd_s;
  /// 0.001 to 100: a shot is rejected where plausible assignments of flashes to images differ by more, see
  /// host/session/shot.hpp.
  double match_tolerance_percent = 1.0;
};

struct RigFile {
  std::string rig;
  std::optional<std::string> lcm_url;
  std::optional<std::string> key_file;  ///< of the lab's key
  BallSettings ball;
  AnalysisSettings analysis;
  CameraTable camera;
  reduction::Record record;
  Statements statements;                ///< for reports
  std::vector<Instrument> instruments;  ///< likewise
  CommissionTable commission;
  PlanFile plan;
  PlanLimits limits;                      ///< as far as the file names them
  std::optional<double> machine_lag_s;    ///< trigger to touchdown
  std::optional<double> machine_pulse_s;  ///< of the trigger
  std::optional<double> shutter_lag_s;    ///< line to open
  std::string text;                       ///< the file as it was read
  std::string calibration_text;           ///< likewise that which camera.calibration names
  std::string ball_text;                  ///< likewise that of ball.kind
};

/// Fails with "FILE:LINE: table.key: what".
Result<RigFile> read_rig(std::string_view text, const std::string& file_name);

/// Reads the file, or the shipped example if the path is empty, and the calibration and the ball's file that
/// it names; relative camera.folder and key_file are then beside the file. Fails with the file's name.
Result<RigFile> load_rig(const std::string& path);

/// Name of the file, beside the rig file, in which a session keeps that of ball.kind ("ball-golf.toml"): it
/// goes before the one that the rig file names, so that a session keeps its numbers. Empty without ball.kind.
std::string kept_ball_file(const BallSettings& ball);

/// The rig file with this text for that of its ball's kind; keys of its [ball] go before what the text says.
Result<RigFile> with_ball_kind(RigFile rig, std::string_view text, const std::string& file_name);

/// The settings of a ball of that kind alone.
BallSettings settings_of(const balls::Kind& kind);

}  // namespace strobe::host
