// Why a message on the command channel is ignored: its sender is not authenticated, or it is not for this
// firmware now.
#pragma once

#include <cstddef>

namespace strobe::authentication {

enum class Rejection {
  malformed,  ///< no sealed command, or its body is no command
  oversized,  ///< larger than any command
  forged,     ///< not sealed with this lab's key, or altered since
  replayed,   ///< a command of this host with that number or a later one came before
  stale,      ///< for an earlier start of this firmware
  other_rig,  ///< for another rig of the same lab
};
inline constexpr std::size_t kRejectionCount = 6;

constexpr const char* name(Rejection rejection) {
  constexpr const char* kNames[kRejectionCount] = {"malformed", "oversized", "forged",
                                                   "replayed",  "stale",     "for another rig"};
  return kNames[static_cast<std::size_t>(rejection)];
}

}  // namespace strobe::authentication
