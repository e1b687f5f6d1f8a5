// The rig file's [commission]: what `strobe commission` holds a rig against, and how long its record is good. Each field is
// a key of that name. No I/O; thread-safe.
#pragma once

#include <optional>
#include <string>

#include "common/config/toml_reader.hpp"
#include "common/flight/gravity.hpp"

namespace strobe::host {

struct CommissionTable {
  /// Where the record is kept, beside the rig file unless it begins with /; absent: RIG.commission.jsonl for RIG.toml.
  std::optional<std::string> record;
  double max_age_days = 90.0;  ///< 0.01 to 100,000; reports and `strobe fire` tell of an older record

  double delay_tolerance_us = 3.0;    ///< 0.1 to 1000; of a lamp's mean delay about the rig file's
  double jitter_limit_us = 5.0;       ///< 0.1 to 1000; sd of a lamp's delay from flash to flash
  double skew_limit_us = 5.0;         ///< 0.1 to 1000; mean of A - B where both flash
  double shutter_tolerance_ms = 3.0;  ///< 0.1 to 1000; of its mean lag about the rig file's

  double brightness_ratio = 1.5;  ///< 1.01 to 100; of the brighter lamp on the picture to the dimmer one
  int balls = 9;                  ///< 2 to 1000; thrown for gravity, noise and repeatability
  /// Where photographs of a printed chessboard are put, beside the rig file unless it begins with /; absent: nowhere.
  std::optional<std::string> board_folder;
  int board_columns = 9;          ///< 3 to 100; inner corners
  int board_rows = 6;             ///< 3 to 100
  double board_spacing_mm = 0.0;  ///< 0.1 to 1000; side of a square; 0 (key absent): not known
  double gravity_mps2 = flight::kStandardGravity_mps2;  ///< 9.7 to 9.9; the place's own
};

/// What is wrong is reported to the table's reader.
CommissionTable read_commission(config::TomlTable table);

}  // namespace strobe::host
