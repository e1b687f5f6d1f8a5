// The end of a series: events that were lost on the way are fetched from strobed's journal before the host's
// log is closed. No I/O; single-threaded.
#pragma once

#include <cstdint>

#include "host/session/session.hpp"

namespace strobe::host {

class GapRecovery {
 public:
  /// now_ns: on the clock that the session is given.
  explicit GapRecovery(std::int64_t now_ns) : started_ns_(now_ns) {}

  /// Whether no event is missing, by a status that was sent after the start, or none more is to be had: the
  /// firmware is silent and nothing was missing, nothing new has come for 15 s (networks are cut for ten), or
  /// a minute is over. To be called at least every second.
  bool finished(const Session& session, std::int64_t now_ns);

 private:
  std::int64_t started_ns_;
  std::int64_t progress_ns_ = 0;  ///< when something new came last
  std::int64_t received_ = 0;
};

}  // namespace strobe::host
