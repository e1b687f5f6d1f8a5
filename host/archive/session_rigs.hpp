// The rig files of a session: the folder's rig.toml, and where a later run used another one, or another calibration, those
// that it kept. Reads files; allocates.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

class SessionRigs {
 public:
  /// rig_path: in place of all that the folder has; empty: none is given. logs: the hosts' of the folder. Fails with the
  /// file's name.
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

}  // namespace strobe::host
