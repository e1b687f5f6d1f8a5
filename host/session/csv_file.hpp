// A table of comma-separated values that grows by whole lines over any number of runs. Writes a file; one
// thread's.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "host/session/record_file.hpp"

namespace strobe::host {

/// A cell as it stands in a line: in quotes where need be (RFC 4180).
std::string csv_field(const std::string& text);
/// The cells of a line, without their quotes.
std::vector<std::string> csv_fields(std::string_view line);

class CsvFile {
 public:
  /// Opens for appending; writes the header if the file is new. A last line without its end is closed if it has
  /// all columns, as a person's editor may leave it; else a write was cut short there, and it is removed. A file
  /// with the header of an earlier version, which lacked the last columns, keeps it: they are then left out of
  /// each line, and must hold no commas. Fails if the file has any other header, or cannot be read or written.
  static Result<CsvFile> open(const std::filesystem::path& path, const std::string& header,
                              const std::vector<std::string>& earlier = {});

  /// One write per line, or lines. What cannot be written waits and is
  /// tried again (record_file.hpp).
  Result<void> append(const std::string& line);

  /// Columns at the end of the header that the file, an earlier version's, does not have.
  std::size_t left_out() const { return static_cast<std::size_t>(left_out_); }

  RecordFile& file() { return file_; }
  const RecordFile& file() const { return file_; }

 private:
  CsvFile(RecordFile file, std::ptrdiff_t left_out) : file_(std::move(file)), left_out_(left_out) {}

  RecordFile file_;
  std::ptrdiff_t left_out_ = 0;  ///< columns at the end of a line that the file does not have
};

}  // namespace strobe::host
