// A session as its folder holds it: runs of `strobe fire`, and every shot that they fired, with its
// photograph, its digitizations and its readout computed again. Plain values; thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/run_record.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

/// Every path in it begins with `folder`.
struct StoredSession {
  std::filesystem::path folder;             ///< as it was named, perhaps relative to the working directory
  RigFile rig;                              ///< as used
  std::string plan_text;                    ///< likewise
  std::vector<std::filesystem::path> logs;  ///< those that were read, oldest first
  std::vector<RunRecord> runs;              ///< oldest first; of hosts without a record only utc and host_id
  std::vector<Shot> shots;                  ///< as fired; dry ones are left out
  std::vector<std::string> remarks;         ///< what could not be read or is missing, a sentence each
  std::vector<std::string> advice;          ///< what an operator can do about that, likewise
  bool verified = false;                    ///< all is sealed with the lab's key
};

// Reads a session's folder: its host logs in the order of their writing (a shot may begin in one and end in
// the next), strobed's journals where they lie beside them, runs.jsonl, the photographs and the corrected
// digitizations. Reads files; not thread-safe with a host that still writes there.

struct ReadSessionOptions {
  std::string rig_path;  ///< empty: the folder's rig.toml
  std::string key_file;  ///< empty: as `strobe key` finds it; without a key the session is unverified
  /// Told now and then: share of the work done, 0 to 1. Empty: nobody.
  std::function<void(double)> progress;
};

/// Every shot that the session's runs fired is in the result, whatever became of it. Fails with one line that
/// names what is not there: the folder, a log in it, a rig file.
Result<StoredSession> read_session(const std::filesystem::path& folder,
                                   const ReadSessionOptions& options = {});

/// The shot of that name (Shot::name). Fails with the names that there are.
Result<const Shot*> find_shot(const StoredSession& session, const std::string& name);

}  // namespace strobe::host
