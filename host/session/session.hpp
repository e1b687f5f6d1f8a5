// The session as messages tell it: what the firmware is doing, which shots wait for their photograph, and the
// readout of each shot once. Deterministic in the messages and times it is given; no I/O; single-threaded.
//
// The time that ends the wait for a photograph is the firmware's own clock as its status messages tell it, so
// that a log played back at any speed gives the same readouts. Only when the firmware has fallen silent does
// the host's clock end it. Time in which the firmware was not heard does not count: what was sent in it comes
// again. An instant of a boot is only ever compared with that boot's: the next one's clock may begin anew.
//
// No number is given without all events of its shot, or else with the flag events_missing. Of a shot that has
// no end, since the firmware died in it, that is all that can be said.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <utility>
#include <vector>

#include "common/shot/recent_map.hpp"
#include "common/shot/shot_key.hpp"
#include "common/units/time.hpp"
#include "host/assembly/assemble.hpp"
#include "host/clock/device_clock.hpp"
#include "host/messages/event_ledger.hpp"
#include "host/session/live_boots.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

/// Heartbeats come twice a second; five lost in a row mean that the firmware is gone.
inline constexpr Duration kSilent = milliseconds{2500};

/// How long the firmware was heard, by its own clock, over all its boots: a time that only messages move, so
/// that a log played back at any speed moves it alike. Time in which no heartbeat came does not count.
class HeardTime {
 public:
  static constexpr std::size_t kMaxBoots = 64;

  void on_heartbeat(std::int64_t boot_id, MonoTime sent);
  Duration now() const { return now_; }
  /// A boot's instant, before or after its newest heartbeat; nullopt if no heartbeat of that boot has come.
  std::optional<Duration> at(std::int64_t boot_id, MonoTime instant) const;

 private:
  struct Boot {
    MonoTime newest;
    Duration at{};  ///< now_ then
  };
  Duration now_{};
  RecentMap<std::int64_t, Boot> boots_{kMaxBoots};
};

class Session {
 public:
  /// A host that fires gives its host id: it wants a readout of each of its own shots however late the shot
  /// is heard of. 0: a passive one. from_start: it can ask, and wants all events of the running boot, also
  /// those from before it joined.
  Session(AssemblySettings settings, std::int64_t firing_host_id, bool from_start)
      : settings_(std::move(settings)), host_id_(firing_host_id), ledger_(from_start) {}
  Session(AssemblySettings settings, std::int64_t firing_host_id)
      : Session(std::move(settings), firing_host_id, firing_host_id != 0) {}

  /// sender: its IP address; may be empty.
  void on_status(const strobe_msgs::status_t& status, HostTime now, const std::string& sender = "");
  void on_event(const strobe_msgs::event_t& event, HostTime now);
  void on_shot(const strobe_msgs::shot_t& shot, HostTime now);
  void on_frame(const strobe_msgs::frame_t& frame, HostTime now);
  void on_time(HostTime now);
  /// This machine's clocks, now and then: tells that its wall clock was set, or that it was suspended.
  void on_local_clocks(const HostReading& reading);
  /// No message will come any more: shots that still wait end without a photograph.
  void on_end();

  /// Shots of these hosts are this one's, too: of earlier runs, which ended before their results came. What
  /// is not yet known of them is then asked for.
  void adopt(const std::set<std::int64_t>& hosts) { adopted_.insert(hosts.begin(), hosts.end()); }
  bool adopted(std::int64_t host_id) const { return adopted_.contains(host_id); }
  /// The shot has a result from before: it gets none.
  void mark_known(const ShotKey& key);
  /// As long as it is held, no adopted shot ends for want of a photograph.
  void hold_photograph_timeouts(bool hold) { holds_ = hold; }
  /// Whether an adopted shot is still under way, or waits for its photograph or for events.
  bool waits_for_adopted() const;
  /// Adopted shots of which the summary is not to be had end without.
  void give_up_adopted();

  std::vector<Shot> take_shot_results() { return std::exchange(shot_results_, {}); }
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

  /// Who a host said to be when it armed; empty: it is not known.
  std::string host_name(std::int64_t host_id) const;
  /// What the firmware last said of outputs that may be active, until it says that they are not; else what is
  /// not confirmed of a DISARM; else empty.
  const std::string& danger() const { return danger_.empty() ? unconfirmed_ : danger_; }
  /// Of a DISARM, for a person; empty: there is none that is overdue. Returns true if these words are new
  /// ones to tell.
  bool set_unconfirmed(const std::string& words) {
    const bool news = !words.empty() && words != unconfirmed_;
    unconfirmed_ = words;
    return news;
  }

  /// Which boots are heard; more than one rig of the name.
  LiveBoots& boots() { return boots_; }
  const LiveBoots& boots() const { return boots_; }
  EventLedger& ledger() { return ledger_; }
  const EventLedger& ledger() const { return ledger_; }
  const std::optional<strobe_msgs::status_t>& status() const { return status_; }
  /// The newest status; absent if the firmware is silent: none has come for 2.5 s, five heartbeats in a row.
  std::optional<strobe_msgs::status_t> live_status(HostTime now) const;
  /// When the newest status arrived.
  HostTime status_heard() const { return status_heard_; }
  std::size_t waiting_for_photograph() const;
  DeviceClock& clock() { return clock_; }
  const DeviceClock& clock() const { return clock_; }

 private:
  static constexpr std::size_t kMaxArmed = 4096;
  static constexpr std::size_t kMaxHeldFrames = 64;
  /// A network that is cut for so long has lost nothing yet.
  static constexpr Duration kCutOff = std::chrono::seconds{10};

  struct PendingShot {
    strobe_msgs::shot_t shot;
    std::optional<strobe_msgs::frame_t> frame;  ///< is here; events of the shot are not
    Duration deadline{};                        ///< as heard_
    HostTime local_deadline;
    std::int64_t number = 0;  ///< in the order of arrival
    HostTime asked;
    bool past = false;  ///< over before this session was joined: nobody promised a readout
  };
  /// A shot whose start was heard, and not its summary.
  struct OpenShot {
    std::int64_t started = 0;  ///< sequences; 0: not heard
    std::int64_t ended = 0;
    HostTime since;  ///< of the end, or of the last time that the summary was asked for
    int asked = 0;
    bool dry = false;
  };

  struct FinishedShot {
    std::optional<std::uint64_t> frame_hash;  ///< of the newest frame that came; nothing: none yet
    bool photograph_missed = false;           ///< it was waited for in vain
  };

  void finish(const strobe_msgs::shot_t& shot, const strobe_msgs::frame_t& frame);
  void finish_without_photograph(const strobe_msgs::shot_t& shot, reduction::Flag why, std::string problem);
  void finish_late(const PendingShot& waiting, const std::string& problem);
  void finish_dry(const strobe_msgs::shot_t& shot);
  void finish_interrupted(const ShotKey& key, const OpenShot& open, const char* why);
  void finish_complete_shots();
  void finish_interrupted_shots();
  bool whole(const strobe_msgs::shot_t& shot) const;
  void add_flags(const strobe_msgs::shot_t& shot, reduction::FlagSet& flags) const;
  bool own(const strobe_msgs::shot_t& shot) const {
    return (host_id_ != 0 && shot.host_id == host_id_) || adopted(shot.host_id);
  }
  std::int64_t host_of(const ShotKey& key, const OpenShot& open) const;
  bool outdated(const strobe_msgs::status_t& status, HostTime now) const;
  bool ran_earlier(std::int64_t boot_id) const;
  void set_deadline(PendingShot& waiting) const;
  /// Each shot is finished once.
  void mark_finished(const ShotKey& key, FinishedShot how);
  void push(Shot shot_result) {
    shot_result.clock_drift_ppm = clock_.state().drift_ppm;
    shot_results_.push_back(std::move(shot_result));
  }
  bool ball_came_after_abort(const strobe_msgs::shot_t& shot) const;
  std::optional<strobe_msgs::frame_t> take_early_frame(const ShotKey& key);
  std::map<ShotKey, PendingShot>::iterator waiting_for(const strobe_msgs::frame_t& frame);
  void keep_or_report_frame(const strobe_msgs::frame_t& frame);
  void expire(HostTime now);
  bool over(const PendingShot& waiting, bool silent, HostTime now) const;
  void request_lost_summaries(HostTime now);
  void request_lost_photographs(HostTime now);
  void report_clock();
  void report_danger(const strobe_msgs::status_t& status, HostTime now);
  void report_arming(const strobe_msgs::status_t& status);
  void notify(std::string text) { notifications_.push_back(std::move(text)); }

  AssemblySettings settings_;
  std::int64_t host_id_;
  std::set<std::int64_t> adopted_;
  bool holds_ = false;
  EventLedger ledger_;
  std::optional<strobe_msgs::status_t> status_;
  LiveBoots boots_;
  DeviceClock clock_;
  HostTime status_heard_;
  std::int64_t answered_boot_ = 0;  ///< that gave this host a token
  HeardTime heard_;
  std::int64_t arrivals_ = 0;
  std::map<ShotKey, PendingShot> pending_;
  RecentMap<ShotKey, strobe_msgs::frame_t> early_frames_{kMaxHeldFrames};  ///< that came before their shot
  std::map<ShotKey, FinishedShot> done_;
  std::map<ShotKey, OpenShot> open_;
  RecentMap<std::pair<std::int64_t, std::int64_t>, std::int64_t> armed_{
      kMaxArmed};  ///< boot, sequence: by whom
  RecentMap<std::int64_t, std::string> host_names_{kMaxArmed};
  std::string danger_, unconfirmed_;
  HostTime danger_told_;
  std::int64_t arming_told_ = 0;  ///< the host
  std::vector<Shot> shot_results_;
  std::vector<std::string> notifications_;
};

}  // namespace strobe::host
