// The end of a series: events that were lost on the way are fetched from the journal before the log is
// closed. No I/O; single-threaded.
#pragma once

#include <cstdint>

#include "host/session/session.hpp"

namespace strobe::host {

class GapRecovery {
 public:
  /// now_ns: the caller's steady clock, on which the session hears.
  explicit GapRecovery(std::int64_t now_ns) : started_ns_(now_ns) {}

  /// Whether all is here, as far as the firmware says, or no more is to be had: nothing was missing when it
  /// fell silent, or nothing new has come for 15 seconds (a network may be cut for ten), or a minute is over.
  /// What must have come is told by a status that was sent after the start.
  bool over(const Session& session, bool firmware_heard, std::int64_t now_ns);

  std::int64_t started_ns() const { return started_ns_; }

 private:
  std::int64_t started_ns_;
  std::int64_t progress_ns_ = 0;  ///< when something new came last
  std::int64_t received_ = 0;
};

}  // namespace strobe::host
