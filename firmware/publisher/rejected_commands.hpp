// How many packets of the command channel were ignored since the start, by what was wrong with them. A plain
// value.
#pragma once

#include <cstdint>

namespace strobe::firmware {

struct RejectedCommands {
  std::int64_t malformed = 0;  ///< not decodable
  std::int64_t oversized = 0;  ///< longer than any command
  std::int64_t forged = 0;     ///< not sealed with this lab's key, or altered
  std::int64_t replayed = 0;   ///< sealed, but not newer than the last one of its host
  std::int64_t stale = 0;      ///< sealed for another start of this firmware
  std::int64_t other_rig = 0;  ///< sealed for another rig

  bool operator==(const RejectedCommands&) const = default;
};

}  // namespace strobe::firmware
