// Reads LCM's log format record by record and, unlike LCM's own reader, continues after damage: a torn or
// zero-filled tail hides no record before it, a damaged part none after it. Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/wire/lcm_log_record.hpp"

namespace strobe::wire {

struct LogRecord {
  std::int64_t offset = 0;   ///< of the record in the file
  std::int64_t wall_us = 0;  ///< when it was written, microseconds since 1970
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

class LogReader {
 public:
  /// Read at once, unless a record is larger.
  static constexpr std::size_t kPart_bytes = std::size_t{16} << 10;
  /// Strobed's own messages are smaller: a shot of 4000 flashes with 128 notes takes 0.4 MB.
  static constexpr std::uint32_t kLargestMessage_bytes = std::uint32_t{1} << 20;

  explicit LogReader(const std::filesystem::path& path) : file_(path, std::ios::binary) {}
  /// Returns false if no whole record follows; more may follow later if the file is still being written.
  bool next(LogRecord& record);
  enum class Step { record, searching, end };
  /// next() in bounded steps: each reads at most one record and one part of the file. `searching`: none is
  /// here, and the place is now further on.
  Step advance(LogRecord& record);
  void seek(std::int64_t offset) { at_ = offset; }
  /// Offset at which the last record ends.
  std::int64_t at() const { return at_; }
  /// From the file, since it was opened.
  std::int64_t bytes_read() const { return bytes_read_; }

 private:
  bool holds(std::int64_t offset, std::size_t size) const;
  bool hold(std::int64_t offset, std::size_t size);
  bool read(std::int64_t offset, std::uint8_t* bytes, std::size_t size);
  bool read_record(std::int64_t offset, LogRecord& record);

  std::ifstream file_;
  std::vector<std::uint8_t> part_;  ///< of the file, from part_at_; written parts never change
  std::int64_t part_at_ = 0;
  std::int64_t at_ = 0;
  std::int64_t bytes_read_ = 0;
};

/// Sync word, number, time, channel's length, data's length.
inline constexpr std::size_t kLogHeaderSize = 28;

}  // namespace strobe::wire
