// Why a message on the command channel is not obeyed, nor answered: its sender is not known to be one of the
// lab's hosts, or it was not meant for this firmware now.
#pragma once

#include <cstddef>

namespace strobe::authentication {

enum class Rejection {
  malformed,  ///< not a sealed command, or one whose body is no command
  oversized,  ///< larger than any command
  forged,     ///< not sealed with this lab's key, or altered since
  replayed,   ///< this host's command of that number, or a later one, came before
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
