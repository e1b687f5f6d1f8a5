// What earlier runs of `strobe fire` left in a session's folder: the results that are in its table, and the
// messages in its logs that are sealed with the lab's key. Reads files; allocates; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <utility>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/session/run_record.hpp"

namespace strobe::host {

/// A heartbeat as a run heard it, by that run's clock: the wall clock at its start, gone on evenly.
struct HeardHeartbeat {
  std::int64_t boot_id = 0;
  DeviceReading device;
  HostTime heard;  ///< since 1970
};

struct FormerRuns {
  std::vector<RunRecord> runs;      ///< oldest first
  std::set<std::int64_t> host_ids;  ///< of the runs, and of whoever sent a FIRE that a log holds
  std::map<ShotKey, bool> results;  ///< in results.csv: whether the shot counts
  std::vector<strobe_msgs::event_t> events;
  std::map<ShotKey, strobe_msgs::shot_t> shots;
  std::map<ShotKey, strobe_msgs::frame_t> frames;  ///< of each shot the first: the readout is of that
  std::set<ShotKey> read_out;                      ///< whose readout one of the runs has published
  std::vector<HeardHeartbeat> heartbeats;
  std::set<std::pair<std::int64_t, std::int64_t>> tokens;  ///< boot and token of each FIRE that a log holds

  bool empty() const { return host_ids.empty(); }
  /// Whether a run fired the shot, as its summary says.
  bool own(const strobe_msgs::shot_t& shot) const { return host_ids.contains(shot.host_id); }
  /// Shots in the table that count.
  int counted() const;
  /// Shots of the runs, not dry, whose summary a log holds and the table has no result of.
  std::set<ShotKey> unfinished() const;
  /// Whether a run may have fired a shot of which there is no result: one that is unfinished, or a FIRE
  /// without a summary, which may have been refused.
  bool may_lack_results() const;
};

/// results.csv of a folder: whether each shot in it counts. None if there is no such file. A shot that is
/// there twice is what its last row says. Fails with the name of a file that cannot be read: what it holds is
/// not known then.
Result<std::map<ShotKey, bool>> read_result_rows(const std::filesystem::path& folder);

/// Logs but for `own_log`. rig: the name on the channels. Fails likewise; a log is read as far as it can be.
Result<FormerRuns> read_former_runs(const std::filesystem::path& folder, const std::string& rig,
                                    const authentication::Key& key,
                                    const std::filesystem::path& own_log = {});

}  // namespace strobe::host
