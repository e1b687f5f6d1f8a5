// Logs played to a host loop, which computes all readouts again: the loop of every replay. Reads files; one
// thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/authentication/packet_seal.hpp"
#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "common/units/time.hpp"
#include "host/archive/stored_logs.hpp"
#include "host/loop/host_loop.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

/// Whether a log has a packet that is sealed with the lab's key. It is then reduced from those alone; a log
/// without, of another lab or of a journal, which is never sealed, as unverified. Absent: it has no message
/// of the rig's firmware.
std::optional<bool> is_sealed(const std::filesystem::path& log, const std::string& rig,
                              const authentication::Key& key);

class LogPlayer {
 public:
  /// key: the logs are sealed with it; absent: they are reduced as unverified. budgets: see AssemblySettings.
  LogPlayer(const RigFile& rig, const std::optional<authentication::Key>& key, bool budgets = false);

  HostLoop& loop() { return loop_; }
  /// When the message that is being played was logged, by the clock of its writer.
  WallTime logged() const { return logged_; }

  /// Told of each message before the loop has it.
  using Watcher = std::function<void(const LogMessage&)>;
  void play(StoredLogs& logs, const Watcher& watcher = {});
  /// Of a journal, whose messages nobody sealed: what the logs lack of it. handler: told of all that is in
  /// it.
  void complete_from(StoredLogs& journal, MessageHandler& handler);
  /// No message will come any more.
  void end() { loop_.end_session(); }

 private:
  /// The clock of whoever wrote the logs.
  class LogClock final : public Clock {
   public:
    HostReading read() override { return {HostTime{now}, WallTime{now}, now}; }
    Duration now{};
  };

  std::string rig_;
  LogClock clock_;
  WallTime logged_;
  NullTransport transport_;
  HostLoop loop_;
};

// Which shots the logs of a session tell of, who fired them, and what became of each. No I/O; one thread's.

/// Where a host was first heard of.
struct HostHeard {
  WallTime time;
  std::size_t log = 0;  ///< of the reader's
};

struct LoggedFrame {
  WallTime time;
  strobe_msgs::frame_t frame;
};

struct LoggedShot {
  bool dry = false;
  std::int64_t host_id = 0;  ///< 0: not known
  std::optional<strobe_msgs::shot_t> summary;
  bool from_journal = false;  ///< no host's log has the summary
  std::optional<Shot> result;
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

  const std::map<ShotKey, LoggedShot>& all() const { return shots_; }
  /// Boots of the firmware, and when each was first heard of.
  const std::map<std::int64_t, WallTime>& boots() const { return boots_; }
  /// Hosts whose commands are in these logs: a log has its own host's alone.
  const std::map<std::int64_t, HostHeard>& commanding_hosts() const { return commanding_; }
  /// Hosts whose readouts are in the logs.
  const std::map<std::int64_t, HostHeard>& reading_hosts() const { return reading_; }
  /// The shot's newest frame in the hosts' logs; null: there is none.
  const LoggedFrame* frame(const ShotKey& key) const;
  /// A frame that came when the wait for it was over here, and from which a later run has told a readout all
  /// the same.
  const LoggedFrame* late_frame(const ShotKey& key) const;

 private:
  void on_shot_result(const Shot& result) override;
  void on_event(const strobe_msgs::event_t& event) override;
  void on_shot(const strobe_msgs::shot_t& shot) override;
  void on_status(const strobe_msgs::status_t&) override {}
  void on_frame(const strobe_msgs::frame_t&) override {}
  void watch_command(const LogMessage& message);
  void watch_readout(const LogMessage& message, authentication::Bytes bytes);
  LoggedShot& heard_of(const ShotKey& key);
  std::int64_t host_of(std::int64_t boot_id, std::int64_t started) const;

  LogPlayer& player_;
  std::string command_channel_, readout_channel_, frame_channel_;
  bool in_journal_ = false;
  std::map<ShotKey, LoggedShot> shots_;
  std::map<std::int64_t, WallTime> boots_;
  std::map<std::int64_t, HostHeard> commanding_, reading_;
  std::map<ShotKey, LoggedFrame> frames_;
  std::map<ShotKey, WallTime> read_out_;                                 ///< the newest readout of each shot
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> armed_;  ///< boot, sequence: by whom
};

}  // namespace strobe::host
