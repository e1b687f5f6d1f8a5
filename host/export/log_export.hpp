// An LCM log's messages as tables or JSON lines. Reads a log record by record, so that a log of any size takes the memory
// of one message, and goes on after damage. Reads files; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/export/message_rows.hpp"

namespace strobe::host {

struct LogExportOptions {
  std::set<std::string> kinds;             ///< "EVENT", "SHOT" ...; empty: all
  std::optional<authentication::Key> key;  ///< with it each packet's seal is checked
};

/// What of a log could not be given.
struct LogExportRemains {
  std::int64_t messages = 0;       ///< that were given
  std::int64_t undecodable = 0;    ///< packets that are no message of this version
  std::int64_t damaged_bytes = 0;  ///< that are no record
  std::int64_t first_damage = -1;  ///< offset; -1: none
};

/// Hands over every row of every message. Columns before the message's own: log, record, logged_us, channel, sealed_by
/// (the key's fingerprint), verified. Fails with the file's name if it cannot be read.
Result<LogExportRemains> export_rows(const std::filesystem::path& log, const LogExportOptions& options,
                                     const TakeRow& take);

/// Hands over a line of JSON for every message: log, record, logged_us, channel, kind, sealed_by, verified, message.
Result<LogExportRemains> export_json(const std::filesystem::path& log, const LogExportOptions& options,
                                     const std::function<void(const std::string&)>& take);

/// The logs of a session's folder by name: the hosts', or strobed's journals where there are none; of a file itself.
/// Fails if there are none.
Result<std::vector<std::filesystem::path>> logs_of(const std::filesystem::path& log_or_session);

}  // namespace strobe::host
