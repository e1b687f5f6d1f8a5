// The rig files of a session: the folder's rig.toml, and where a later run used another one, or another
// calibration, those that it kept. Reads files; allocates.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

class SessionRigs {
 public:
  /// rig_path: in place of all that the folder has; empty: none is given. logs: the hosts' of the folder.
  /// Fails with the file's name.
  static Result<SessionRigs> open(const std::filesystem::path& folder, const std::string& rig_path,
                                  const std::vector<std::filesystem::path>& logs);

  /// Never null.
  using Rig = std::shared_ptr<const RigFile>;
  const Rig& main() const { return main_; }
  /// Of the run that wrote this log.
  const Rig& of_log(const std::filesystem::path& log) const;

  /// The lab's key, or nullopt if none can be read. key_file: as of --key-file; empty: none is given.
  std::optional<authentication::Key> key(const std::string& key_file) const;

 private:
  Rig main_;
  std::map<std::string, Rig> others_;  ///< by the log's file name
};

// The photographs that a session keeps, and which shot each shows. Reads a folder; thread-safe; allocates.

/// The number in photographs/shot-0007-NAME; absent: it is no such name.
std::optional<int> shot_number_in(const std::filesystem::path& photograph);

/// The file that a frame names, if it is one of the session's: "photographs/shot-0007-NAME".
std::optional<std::filesystem::path> named_photograph(const std::filesystem::path& session,
                                                      const std::string& name);

struct UnnamedPhotographs {
  std::map<ShotKey, std::filesystem::path> of_shot;
  std::vector<std::string> remarks;  ///< a sentence for each that cannot be told apart
};

/// Photographs that no frame names (`named`), by the number in their names, for those of `without` that have
/// none. One that may show either of two shots is used for neither.
UnnamedPhotographs unnamed_photographs(const std::filesystem::path& session,
                                       const std::set<std::filesystem::path>& named,
                                       const std::vector<ShotKey>& without);

}  // namespace strobe::host
