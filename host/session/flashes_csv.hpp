// flashes.csv: the record of every flash of every shot, one line each, appended over any number of runs.
// Columns: boot_id (hex), shot_id, flash_index, lamps (a, b or ab), commanded_ns, issue_start_ns,
// issue_end_ns, observed_a_ns, observed_b_ns (the firmware's CLOCK_MONOTONIC; sensors' delays subtracted),
// extra_edges. What was not there is empty. Writes a file; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <utility>

#include "common/shot/shot_key.hpp"
#include "host/session/csv_file.hpp"

namespace strobe::host {

std::string flashes_header();
/// The lines of a shot, each with its end.
std::string flashes_lines(const strobe_msgs::shot_t& shot);

class FlashesCsv {
 public:
  /// Fails where CsvFile does. Shots that the file already has are known.
  static Result<FlashesCsv> open(const std::filesystem::path& path);

  /// A known shot changes nothing.
  Result<void> add(const strobe_msgs::shot_t& shot);

 private:

  FlashesCsv(CsvFile file, std::set<ShotKey> known) : file_(std::move(file)), known_(std::move(known)) {}

  CsvFile file_;
  std::set<ShotKey> known_;
};

}  // namespace strobe::host
