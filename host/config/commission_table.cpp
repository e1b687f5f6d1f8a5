#include "host/config/commission_table.hpp"

namespace strobe::host {

CommissionTable read_commission(config::TomlTable table) {
  CommissionTable read;
  if (table.has("record")) read.record = table.string("record");
  read.max_age_days = table.number_or("max_age_days", read.max_age_days, {0.01, 1e5});
  read.delay_tolerance_us = table.number_or("delay_tolerance_us", read.delay_tolerance_us, {0.1, 1000.0});
  read.jitter_limit_us = table.number_or("jitter_limit_us", read.jitter_limit_us, {0.1, 1000.0});
  read.skew_limit_us = table.number_or("skew_limit_us", read.skew_limit_us, {0.1, 1000.0});
  read.shutter_tolerance_ms =
      table.number_or("shutter_tolerance_ms", read.shutter_tolerance_ms, {0.1, 1000.0});
  read.brightness_ratio = table.number_or("brightness_ratio", read.brightness_ratio, {1.01, 100.0});
  read.balls = static_cast<int>(table.integer_or("balls", read.balls, {2.0, 1000.0}));
  if (table.has("board_folder")) read.board_folder = table.string("board_folder");
  read.board_columns = static_cast<int>(table.integer_or("board_columns", read.board_columns, {3.0, 100.0}));
  read.board_rows = static_cast<int>(table.integer_or("board_rows", read.board_rows, {3.0, 100.0}));
  if (table.has("board_spacing_mm")) read.board_spacing_mm = table.number("board_spacing_mm", {0.1, 1000.0});
  read.gravity_mps2 = table.number_or("gravity_mps2", read.gravity_mps2, {9.7, 9.9});
  return read;
}

}  // namespace strobe::host
