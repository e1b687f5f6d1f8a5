// One run of a rig's machine: its CLOCK_MONOTONIC, from the machine's start to its end, on this machine's.
// Offset, drift and how well they are known, from heartbeats. Wall clocks have no part in it, so that setting
// one changes nothing; it is reported. Where the relation breaks (a machine was suspended) a new one begins;
// that is reported, too.
//
// The delay that every message has is part of the offset: instants come out that much late, on one machine
// some 0.1 ms. No I/O; deterministic; one thread's.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/clock/clock_estimate.hpp"
#include "host/clock/clock_fit.hpp"
#include "host/clock/clock_reading.hpp"

namespace strobe::host {

/// How the clocks stand now. Numbers that are not known yet are absent: they take three heartbeats.
struct ClockState {
  std::int64_t heartbeats = 0;      ///< since the relation began
  std::optional<double> drift_ppm;  ///< this machine's clock against the firmware's; positive: it gains
  double drift_sd_ppm = 0.0;
  std::optional<double> offset_s;  ///< this clock less the firmware's at the newest heartbeat, with the delay
  double offset_sd_s = 0.0;
  std::optional<double> latency_s;  ///< of the newest heartbeat, beyond the delay that all have
  double worst_latency_s = 0.0;     ///< of those in the window
  bool suspect = false;             ///< no two machines' clocks differ like this
};

class ClockRelation {
 public:
  /// The window that instants are computed from: longer, and the crystals' wander would count.
  static constexpr Duration kWindow = std::chrono::minutes{2};
  /// What the state is taken from, in which the wander has its part: it shows in minutes only.
  static constexpr Duration kMemory = std::chrono::minutes{10};

  /// Whether a heartbeat may be of this very clock, going on.
  bool may_hold_for(const DeviceReading& device, HostTime heard) const;
  /// A heartbeat: the firmware's clocks when it was sent, and when it was heard. One that was overtaken
  /// changes nothing.
  void on_heartbeat(const DeviceReading& device, HostTime heard);

  // After the first heartbeat:
  /// The firmware's instant on this machine's clock. Instants from before a break are computed by the
  /// relation of their time.
  HostTime local(MonoTime device) const;
  /// New numbers with each of the first forty heartbeats, then every five seconds: they take some 5 to 15 ms.
  ClockState state();
  /// Whether the firmware's machine was suspended between two of its instants, as its own clocks show.
  bool suspended_within(MonoTime from, MonoTime to) const;

  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

 private:
  struct Heartbeat {
    MonoTime sent;
    HostTime heard;
    /// This machine's clock less the firmware's, with the delay.
    Duration offset() const { return heard.time_since_epoch() - sent.time_since_epoch(); }
  };
  /// One relation, as long as it holds.
  struct Segment {
    MonoTime first_sent;
    Duration origin{};  ///< offset of the first: numbers are kept relative to it
    std::int64_t heartbeats = 0;
    double min_offset_s = 0.0;  ///< stands in for the line
    std::optional<ClockLine> line;
  };

  double offset_s(const Segment& segment, MonoTime sent) const;
  double lateness_s(const Heartbeat& heartbeat) const;
  void begin(const Heartbeat& heartbeat);
  void add(const Heartbeat& heartbeat);
  /// Of the last so much time.
  std::vector<ClockSample> points(Duration last) const;
  void renew_estimate();
  bool earlier_than_any(const Heartbeat& heartbeat) const;
  bool broken_by(const Heartbeat& heartbeat);
  const Segment& of(MonoTime device) const;

  ClockStepDetector<MonoTime> device_watch_;
  std::deque<Heartbeat> heartbeats_;  ///< within kMemory
  std::vector<Heartbeat> late_;       ///< in a row, by about the same: the relation may have broken
  std::vector<Segment> segments_;
  MonoTime fitted_;                                    ///< heartbeat that the newest line was fitted at
  std::optional<ClockEstimate> estimate_;              ///< what is shown; no instant is computed from it
  MonoTime estimated_;                                 ///< heartbeat that it was made at
  std::vector<std::pair<MonoTime, MonoTime>> sleeps_;  ///< instants around each
  std::vector<std::string> notifications_;
};

}  // namespace strobe::host
