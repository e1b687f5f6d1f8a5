// A table of comma-separated values that grows by whole lines over any number of runs. Writes a file; one
// thread's.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace strobe::host {

class CsvFile {
 public:
  /// Opens for appending; writes the header if the file is new. A last line that a killed process left
  /// without its end is closed first. A file with the header of an earlier version, which lacked the last
  /// columns, keeps it: they are then left out of each line, and must hold plain numbers. Fails if the file
  /// has any other header.
  static Result<CsvFile> open(const std::filesystem::path& path, const std::string& header,
                              const std::string& earlier = "");
  CsvFile(CsvFile&& other) noexcept;
  CsvFile& operator=(CsvFile&&) = delete;
  ~CsvFile();

  /// One write per line: lines of several processes do not mix.
  Result<void> append(const std::string& line);

 private:
  CsvFile(std::filesystem::path path, int fd, std::ptrdiff_t left_out)
      : path_(std::move(path)), fd_(fd), left_out_(left_out) {}

  std::filesystem::path path_;
  int fd_ = -1;
  std::ptrdiff_t left_out_ = 0;  ///< columns at the end of a line that the file does not have
};

}  // namespace strobe::host
