// A table of comma-separated values that grows by whole lines over any number of runs. Writes a file; one
// thread's.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace strobe::host {

class CsvFile {
 public:
  /// Opens for appending; writes the header if the file is new. A last line that a killed process left
  /// without its end is closed first. Fails if the file has another header.
  static Result<CsvFile> open(const std::filesystem::path& path, const std::string& header);
  CsvFile(CsvFile&& other) noexcept;
  CsvFile& operator=(CsvFile&&) = delete;
  ~CsvFile();

  /// One write per line: lines of several processes do not mix.
  Result<void> append(const std::string& line);

 private:
  CsvFile(std::filesystem::path path, int fd) : path_(std::move(path)), fd_(fd) {}

  std::filesystem::path path_;
  int fd_ = -1;
};

}  // namespace strobe::host
