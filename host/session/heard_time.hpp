// How long the firmware was heard, by its own clock, over all its boots: a time that only messages move, so that
// a log played back at any speed moves it alike. Time in which no heartbeat came does not count. No I/O;
// single-threaded.
#pragma once

#include <cstdint>
#include <optional>

#include "common/shot/recent_map.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

/// Heartbeats come twice a second; five lost in a row mean that the firmware is gone.
inline constexpr Duration kSilent = milliseconds{2500};

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

}  // namespace strobe::host
