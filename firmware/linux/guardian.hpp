// strobed's parent. It forks the worker before anything is opened, and when the worker dies, by whatever
// cause, hangs, or can no longer drive its outputs, it takes the output lines over and drives them inactive.
// It does little else (it passes signals on, and speaks to the service manager), so that it cannot fail with
// the worker; its memory is locked and its priority one above the loop's, where that is allowed.
//
// A hung loop is known within 0.2 s, and killed at once; while it is in doubt the guardian looks from the
// core that the loop ran on, and cannot be taken in by a core that stands still. Without a real-time priority
// it waits for 0.6 s. With a hung publisher the loop is asked to stop first, which makes the outputs safe: a
// thread that the kernel holds in a dead disk keeps the lines open even after a kill.
#pragma once

#include <functional>

#include "firmware/core/rig.hpp"
#include "firmware/linux/shared_status.hpp"

namespace strobe::firmware {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitBadInput = 2;

/// A guardian that has not come round for so long watches no more: the worker is to stop.
inline constexpr Duration kGuardianTimeout = milliseconds(5'000);

/// Runs `work` in a child whose SIGTERM, SIGINT and SIGHUP are blocked (it waits for them) and that gets
/// SIGTERM if the guardian dies. Returns the exit status of strobed: 0 orderly stop, 2 as the worker gives it
/// before it had the lines, 1 all else. Call it while the process has one thread and no descriptors of its
/// own.
int run_guardian(const Rig& rig, const std::function<int(SharedStatus&)>& work);

}  // namespace strobe::firmware
