// flashes.csv: the record of every flash of every shot, one line each, appended over any number of runs.
// The columns of data_dictionary.hpp. What was not there is empty. Writes a file; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
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
  /// Fails where CsvFile does. Flashes that the file already has are known.
  static Result<FlashesCsv> open(const std::filesystem::path& path);

  /// Known flashes change nothing; those that a cut-short write left out are added.
  Result<void> add(const strobe_msgs::shot_t& shot);

  RecordFile& file() { return file_.file(); }
  const RecordFile& file() const { return file_.file(); }

 private:
  using FlashKey = std::pair<ShotKey, std::int32_t>;
  static std::set<FlashKey> flashes_in(std::istream& lines);
  FlashesCsv(CsvFile file, std::set<FlashKey> known) : file_(std::move(file)), known_(std::move(known)) {}

  CsvFile file_;
  std::set<FlashKey> known_;
};

}  // namespace strobe::host
