// The LCM logs of a session's folder. Several are read as one, in order of time, as hosts may have written at
// once. Reads files; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "common/wire/log_reader.hpp"

namespace strobe::host {

/// One record of a log.
struct LogMessage {
  std::string channel;
  std::span<const std::uint8_t> bytes;  ///< until the next is read
  WallTime time;        ///< as logged; never before that of the record before it in the same log
  std::size_t log = 0;  ///< which of the logs
};

class StoredLogs {
 public:
  /// Fails with the file's name if one cannot be opened.
  static Result<StoredLogs> open(std::vector<std::filesystem::path> logs);

  /// The next message of all, or nullopt: there is none. What is no record is passed over.
  std::optional<LogMessage> next();

  const std::filesystem::path& path(std::size_t log) const { return logs_[log].path; }
  /// Share of all bytes that have been read, 0 to 1.
  double share() const;
  std::int64_t messages() const { return messages_; }
  /// Once all is read: a sentence for each log of which some bytes are no records.
  std::vector<std::string> remarks() const;

 private:
  struct Log {
    std::filesystem::path path;
    WallTime starts;                          ///< by its name; nothing in it is earlier
    std::unique_ptr<wire::LogReader> reader;  ///< while there is more
    wire::LogRecord record;                   ///< the next, if there is more
    WallTime time;
    std::uintmax_t bytes = 0, read = 0;
  };
  explicit StoredLogs(std::vector<Log> logs);
  void open_due();
  bool advance(Log& log);

  std::vector<Log> logs_;
  std::size_t opened_ = 0;
  Log* last_ = nullptr;  ///< whose message was handed out
  std::int64_t messages_ = 0;
};

}  // namespace strobe::host
