// Every boot's CLOCK_MONOTONIC on this machine's, from heartbeats. An instant means nothing without its boot:
// a rig's machine that was started anew begins its clock again, one that stands in for it has a clock of its
// own, and what the earlier boot sent may still come. A restart of strobed alone goes on with the machine's
// clock, and with its relation to this one. Where a relation breaks (a machine was suspended) a new one
// begins, which is reported. Wall clocks have no part in it, so that setting one changes nothing; that is
// reported, too.
//
// A message may come late, also by much and many in a row, but never early. So a relation is the lower
// envelope of the last two minutes' messages: the line below all of them that is nearest to them, which no
// delay can lift (S. B. Moon, P. Skelly, D. Towsley: Estimation and removal of clock skew from network delay
// measurements, INFOCOM 1999). The delay that every message has is part of the offset: instants come out that
// much late, on one machine some 0.1 ms. They tell which photograph is of which shot, for which milliseconds
// are enough. No I/O; deterministic; one thread's.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/clock/machine_clock.hpp"

namespace strobe::host {

/// How the clocks stand now.
struct ClockState {
  std::int64_t heartbeats = 0;  ///< since the relation began
  std::optional<double>
      drift_ppm;  ///< this machine's clock against the firmware's; positive: it gains. After 20 s
  std::optional<double> latency_s;  ///< of the newest heartbeat, beyond the delay that all have
  double worst_latency_s = 0.0;     ///< of those in the last two minutes
  bool suspect = false;             ///< no two machines' clocks differ like this
};

/// One run of a rig's machine, from its start to its end.
class ClockRelation;

class DeviceClock {
 public:
  /// So many boots are known, those first heard latest.
  static constexpr std::size_t kMaxBoots = 64;

  /// A heartbeat: the firmware's clocks when it was sent, and when it was heard. One that was overtaken
  /// changes nothing.
  void on_heartbeat(std::int64_t boot_id, const DeviceReading& device, HostTime heard);
  /// This machine's clocks, now and then.
  void on_local(const HostReading& local);

  /// A boot's instant on this machine's clock; one from before a break by the relation of its time. Returns
  /// nullopt if no heartbeat of that boot has come.
  std::optional<HostTime> local(std::int64_t boot_id, MonoTime device) const;
  /// Of the boot that was heard first latest.
  ClockState state() const;
  /// Whether the boot's machine was suspended between two of its instants, as its own clocks show.
  bool suspended_within(std::int64_t boot_id, MonoTime from, MonoTime to) const;

  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

 private:
  struct Boot {
    std::int64_t id = 0;
    std::shared_ptr<ClockRelation> relation;  ///< other boots of one run of the machine have the same
  };
  const Boot* find(std::int64_t boot_id) const;
  Boot first_heard(std::int64_t boot_id, const DeviceReading& device, HostTime heard) const;

  std::deque<Boot> boots_;  ///< in the order of their first heartbeats
  ClockStepDetector<HostTime> local_watch_;
  std::vector<std::string> notifications_;
};

}  // namespace strobe::host
