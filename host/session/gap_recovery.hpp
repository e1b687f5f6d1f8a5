// The end of a series: events that were lost on the way are fetched from strobed's journal before the host's
// log is closed. No I/O; single-threaded.
#pragma once

#include <cstdint>

#include "host/session/session.hpp"

namespace strobe::host {

class GapRecovery {
 public:
  explicit GapRecovery(HostTime now) : started_(now) {}

  /// Whether no event is missing, by a status that was sent after the start, or none more is to be had: the
  /// firmware is silent and nothing was missing, nothing new has come for 15 s (networks are cut for ten), or
  /// a minute is over. To be called at least every second.
  bool finished(const Session& session, HostTime now);

 private:
  HostTime started_;
  HostTime progress_;  ///< when something new came last
  std::int64_t received_ = 0;
};

}  // namespace strobe::host
