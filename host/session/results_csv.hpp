// results.csv: one line per shot, appended over any number of runs. Writes a file; one thread's.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

/// Columns: utc, boot_id (hex), shot_id, spoilt (why, else empty), each quantity, sd_<quantity>,
/// sd_systematic_<quantity>, regime, court_pace_conforming, method, mirrored, flags (separated by ;), the
/// named notes of notes.hpp, other_notes (key=value separated by ;). What could not be had is empty.
std::string results_header();
std::string results_line(const Outcome& outcome, const std::string& utc);

class ResultsCsv {
 public:
  /// Opens for appending; writes the header if the file is new. A last line that a killed process left
  /// without its end is closed first. Fails if the file has another header.
  static Result<ResultsCsv> open(const std::filesystem::path& path);
  ResultsCsv(ResultsCsv&& other) noexcept;
  ResultsCsv& operator=(ResultsCsv&&) = delete;
  ~ResultsCsv();

  /// One write per line: lines of several processes do not mix.
  Result<void> append(const std::string& line);

 private:
  ResultsCsv(std::filesystem::path path, int fd) : path_(std::move(path)), fd_(fd) {}

  std::filesystem::path path_;
  int fd_ = -1;
};

}  // namespace strobe::host
