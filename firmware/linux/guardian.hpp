// strobed's parent. It forks the worker before anything is opened, and when the worker dies, by whatever
// cause, or hangs, it takes the output lines over and drives them inactive. It does nothing else, so that it
// cannot fail with the worker; its memory is locked and its priority one above the loop's, where that is
// allowed.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "firmware/core/rig.hpp"

namespace strobe::firmware {

/// Shared between worker and guardian.
struct WorkerPage {
  std::atomic<bool> lines_taken{false};    ///< the worker owns the output lines
  std::atomic<bool> outputs_safe{false};   ///< it has left them inactive and ends in good order
  std::atomic<std::int64_t> turned_ns{0};  ///< when its loop last came round; 0: not running yet
};

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitBadInput = 2;

/// Runs `work` in a child whose SIGTERM, SIGINT and SIGHUP are blocked (it waits for them) and that gets
/// SIGTERM if the guardian dies. Returns the exit status of strobed: 0 orderly stop, 2 as the worker gives it
/// before it had the lines, 1 all else. Call it while the process has one thread and no descriptors of its
/// own.
int guard(const Rig& rig, const std::function<int(WorkerPage&)>& work);

}  // namespace strobe::firmware
