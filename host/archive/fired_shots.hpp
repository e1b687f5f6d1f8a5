// Which shots the logs of a session tell of, who fired them, and what became of each. No I/O; one thread's.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>

#include "common/authentication/packet_seal.hpp"
#include "common/shot/shot_key.hpp"
#include "common/units/time.hpp"
#include "host/archive/log_player.hpp"
#include "host/session/shot_result.hpp"

namespace strobe::host {

/// Where a host was first heard of.
struct HostHeard {
  WallTime time;
  std::size_t log = 0;  ///< of the reader's
};

struct LoggedFrame {
  WallTime time;
  strobe_msgs::frame_t frame;
};

struct FiredShot {
  bool dry = false;
  std::int64_t host_id = 0;  ///< 0: not known
  std::optional<strobe_msgs::shot_t> summary;
  bool from_journal = false;  ///< no host's log has the summary
  std::optional<ShotResult> result;
  WallTime heard;  ///< when its summary was logged, else its start
};

/// Listens to logs that are played, and to journals.
class FiredShots final : public HostListener, public MessageHandler {
 public:
  /// rig: whose channels. The player must outlive this.
  FiredShots(LogPlayer& player, const std::string& rig);

  /// Before the loop has it: commands and readouts name hosts, frames have their time.
  void watch(const LogMessage& message);
  /// From now on it is journals that are read.
  void begin_journals() { in_journal_ = true; }

  const std::map<ShotKey, FiredShot>& all() const { return shots_; }
  /// Boots of the firmware, and when each was first heard of.
  const std::map<std::int64_t, WallTime>& boots() const { return boots_; }
  /// Hosts whose commands are in these logs: a log has its own host's alone.
  const std::map<std::int64_t, HostHeard>& commanding_hosts() const { return commanding_; }
  /// Hosts whose readouts are in the logs.
  const std::map<std::int64_t, HostHeard>& reading_hosts() const { return reading_; }
  /// The shot's newest frame in the hosts' logs; null: there is none.
  const LoggedFrame* frame(const ShotKey& key) const;
  /// A frame that came when the wait for it was over here, and from which a later run has told a readout all the same.
  const LoggedFrame* late_frame(const ShotKey& key) const;

 private:
  void on_shot_result(const ShotResult& result) override;
  void on_event(const strobe_msgs::event_t& event) override;
  void on_shot(const strobe_msgs::shot_t& shot) override;
  void on_status(const strobe_msgs::status_t&) override {}
  void on_frame(const strobe_msgs::frame_t&) override {}
  void watch_command(const LogMessage& message);
  void watch_readout(const LogMessage& message, authentication::Bytes bytes);
  FiredShot& heard_of(const ShotKey& key);
  std::int64_t host_of(std::int64_t boot_id, std::int64_t started) const;

  LogPlayer& player_;
  std::string command_channel_, readout_channel_, frame_channel_;
  bool in_journal_ = false;
  std::map<ShotKey, FiredShot> shots_;
  std::map<std::int64_t, WallTime> boots_;
  std::map<std::int64_t, HostHeard> commanding_, reading_;
  std::map<ShotKey, LoggedFrame> frames_;
  std::map<ShotKey, WallTime> told_;                                     ///< the newest readout of each shot
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> armed_;  ///< boot, sequence: by whom
};

}  // namespace strobe::host
