// Reads LCM's log format record by record and, unlike LCM's own reader, continues after damage: a torn or
// zero-filled tail hides no record before it, a damaged part none after it. Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace strobe::firmware {

struct LogRecord {
  std::int64_t offset = 0;   ///< of the record in the file
  std::int64_t wall_us = 0;  ///< when it was written, microseconds since 1970
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

class LogReader {
 public:
  explicit LogReader(const std::filesystem::path& path) : file_(path, std::ios::binary) {}
  /// Returns false if no whole record follows; more may follow later if the file is still being written.
  bool next(LogRecord& record);
  void seek(std::int64_t offset) { at_ = offset; }
  /// Offset at which the last record ends.
  std::int64_t at() const { return at_; }

 private:
  bool read(std::int64_t offset, std::uint8_t* bytes, std::size_t size);
  bool read_record(std::int64_t offset, LogRecord& record);
  bool find_sync(std::int64_t from, std::int64_t& found);

  void fill(std::int64_t offset, std::size_t size);

  std::ifstream file_;
  std::vector<std::uint8_t> part_;  ///< of the file, from part_at_; written parts never change
  std::int64_t part_at_ = 0;
  std::int64_t at_ = 0;
};

inline constexpr std::uint32_t kLogSyncWord = 0xEDA1DA01;
/// Sync word, number, time, channel's length, data's length.
inline constexpr std::size_t kLogHeaderSize = 28;

}  // namespace strobe::firmware
