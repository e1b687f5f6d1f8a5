// Photographs that lie in the camera's folder from before a host's start, matched to shots of earlier runs
// whose result is lacking. Times are those of the earlier runs' logs and of the files. Reads the session's
// folder of photographs; deterministic; single-threaded.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "host/clock/device_clock.hpp"

namespace strobe::host {

struct OldFile {
  std::filesystem::path path;
  HostTime written;  ///< since 1970: the file's own time of its last change
};

struct LeftShots {
  std::vector<strobe_msgs::shot_t> exposures;  ///< all that are known, dry ones and those with a result, too
  std::set<ShotKey> wanted;                    ///< of them: lack a photograph
  std::set<ShotKey> photographed;              ///< of them: have theirs
  std::set<std::string> names_used;            ///< of files that are such photographs, without their folder
};

struct LeftPhotograph {
  std::filesystem::path file;
  ShotKey shot;
  bool kept = false;  ///< the session's own copy
};

/// At most one for each shot that is wanted: the session's copy if an earlier run lived to make it, else a
/// file whose time fits this shot and no other. `clock` has heard the heartbeats of the logs, at times since
/// 1970.
std::vector<LeftPhotograph> match_left_photographs(const LeftShots& shots, std::vector<OldFile> files,
                                                   const std::filesystem::path& session,
                                                   const DeviceClock& clock, double timeout_s);

}  // namespace strobe::host
