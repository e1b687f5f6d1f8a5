// The LCM logs in a session's folder: those that are there, by their names, and the host's own, which grows.
// Reads folders and writes a file; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/session/record_file.hpp"

namespace strobe::host {

/// The hosts' logs in the folder, in the order of their names, which is that of their starts. `error`: why
/// the folder could not be read to its end.
std::vector<std::filesystem::path> host_logs(const std::filesystem::path& folder, std::error_code& error);
/// The firmware's journals in the folder, in the order of their names, which says nothing.
std::vector<std::filesystem::path> journals(const std::filesystem::path& folder, std::error_code& error);

/// The same where a folder that cannot be read is like one without logs.
std::vector<std::filesystem::path> host_logs(const std::filesystem::path& folder);
std::vector<std::filesystem::path> journals(const std::filesystem::path& folder);

/// A host's log: every message it received and published, in LCM's log format, one record each. Messages are
/// on their way to the disk before the call returns, so that a killed host loses none.
class EventLog {
 public:
  /// Makes host-<utc>.lcmlog in the folder, with one more letter where that is taken.
  static Result<EventLog> create(const std::filesystem::path& folder, const std::string& utc);

  /// A message as it came. What cannot be written waits and is tried again (record_file.hpp).
  Result<void> append(const std::string& channel, std::span<const std::uint8_t> message, WallTime wall);

  RecordFile& file() { return file_; }
  const RecordFile& file() const { return file_; }

 private:
  explicit EventLog(RecordFile file) : file_(std::move(file)) {}

  RecordFile file_;
  std::int64_t next_number_ = 0;
};

}  // namespace strobe::host
