// Every boot's CLOCK_MONOTONIC on this machine's. An instant means nothing without its boot: a rig's machine that
// was started anew begins its clock again, one that stands in for it has a clock of its own, and what the
// earlier boot sent may still come. A restart of strobed alone goes on with the machine's clock, and with its
// relation (clock_relation.hpp). No I/O; deterministic; one thread's.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/clock/clock_relation.hpp"

namespace strobe::host {

class DeviceClock {
 public:
  /// So many boots are known, those first heard latest.
  static constexpr std::size_t kMaxBoots = 64;

  /// A heartbeat: the firmware's clocks when it was sent, and when it was heard.
  void on_heartbeat(std::int64_t boot_id, const DeviceReading& device, HostTime heard);
  /// This machine's clocks, now and then.
  void on_local(const HostReading& local);

  /// A boot's instant on this machine's clock. Returns nullopt if no heartbeat of that boot has come.
  std::optional<HostTime> local(std::int64_t boot_id, MonoTime device) const;
  /// Of the boot that was heard first latest.
  ClockState state();
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
