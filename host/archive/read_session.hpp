// Reads a session's folder: its host logs in the order of their writing (a shot may begin in one and end in the next),
// strobed's journals where they lie beside them, runs.jsonl, the photographs and the corrected digitizations. Reads files;
// not thread-safe with a host that still writes there.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "host/archive/stored_session.hpp"

namespace strobe::host {

struct ReadSessionOptions {
  std::string rig_path;  ///< empty: the folder's rig.toml
  std::string key_file;  ///< empty: as `strobe key` finds it; without a key the session is unverified
  /// Told now and then: share of the work done, 0 to 1. Empty: nobody.
  std::function<void(double)> progress;
};

/// Every shot that the session's runs fired is in the result, whatever became of it. Fails with one line that names
/// what is not there: the folder, a log in it, a rig file.
Result<StoredSession> read_session(const std::filesystem::path& folder,
                                   const ReadSessionOptions& options = {});

/// The shot of that name (StoredShot::name). Fails with the names that there are.
Result<const StoredShot*> find_shot(const StoredSession& session, const std::string& name);

}  // namespace strobe::host
