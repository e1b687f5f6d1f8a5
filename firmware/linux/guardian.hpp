// strobed's parent. It requests the output lines and forks the worker, so that both hold them. When the
// worker dies of whatever cause, hangs, or can no longer drive its outputs, the guardian drives them
// inactive. It learns of the loop's death before the kernel takes the worker apart (shared_status.hpp): the
// outputs are inactive within 1 ms. It does little else (it passes signals on, and talks to the service
// manager), so that it does not fail together with the worker; its memory is locked and its priority one
// above the loop's, where allowed.
//
// A loop that hangs while a shot is under way is detected within 0.2 s and killed. While the loop is suspect
// the guardian runs on the loop's core, so that a core that stands still is not mistaken for a hung loop;
// without real-time priority it waits for 0.6 s. While no shot is under way a loop without a sign of life is
// waited for, and told of; the service manager's watchdog gets none meanwhile. If the publisher hangs the
// loop is asked to stop first, which makes the outputs safe: a thread blocked in the kernel by a dead disk
// keeps the lines open even after a kill.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "firmware/core/rig.hpp"
#include "firmware/linux/held_outputs.hpp"
#include "firmware/linux/shared_status.hpp"

namespace strobe::firmware {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitBadInput = 2;

/// The worker stops if the guardian has shown no sign of life for so long.
inline constexpr Duration kGuardianTimeout = milliseconds(5'000);

/// Tells the hosts that outputs may be active: called again and again with the message once the worker of
/// that boot is dead, from a child process without the lines, so that nobody who takes them over waits.
/// Nobody is told if fork() fails.
using TellDanger = std::function<void(std::int64_t boot_id, const std::string& message)>;

/// What the worker does with the page, which it shares with the guardian, as it does the outputs; its exit
/// status.
using Work = std::function<int(SharedStatus&)>;

/// Runs `work` in a child process of a session of its own, which gets SIGTERM if the guardian dies. Its
/// worker_stop_signals() are blocked: it waits for them. Returns strobed's exit status: 0 after an orderly
/// stop, 2 if the outputs could not be taken, which is told on stderr, or the worker gave up before its loop
/// began, else 1. Requires: one thread, and no open descriptors.
int run_guardian(const Rig& rig, const OutputAccess& access, const Work& work, const TellDanger& tell);

}  // namespace strobe::firmware
