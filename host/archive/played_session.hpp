// What the logs and journals of a session's folder tell, once all are played. Reads files; one thread's.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/archive/fired_shots.hpp"
#include "host/archive/log_player.hpp"

namespace strobe::host {

struct PlayedSession {
  std::unique_ptr<LogPlayer> player;  ///< `fired` listens to it
  std::unique_ptr<FiredShots> fired;
  std::map<std::int64_t, std::filesystem::path> log_of_host;
  std::vector<std::string> remarks;  ///< what could not be read, a sentence each
};

/// logs: the hosts', in any order. key: absent: nothing is verified. progress: told the share of the logs that has been
/// read, now and then. Fails with the file that cannot be opened.
Result<PlayedSession> play_session(const std::vector<std::filesystem::path>& logs,
                                   const std::vector<std::filesystem::path>& journals, const RigFile& rig,
                                   const std::optional<authentication::Key>& key,
                                   const std::function<void(double)>& progress);

}  // namespace strobe::host
