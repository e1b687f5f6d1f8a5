// What each signal means to strobed, so that none but SIGKILL and SIGSTOP leaves the outputs as they are. The
// default of most signals is a process's end at once, and of a terminal's Ctrl-Z its standstill; a terminal,
// pkill(1) and a service manager send them to guardian and worker together.
//
//   TERM, INT, HUP, QUIT and all others that would end a process    stop in good order
//   TSTP, TTIN, TTOU, PIPE, XFSZ                                     ignored
//   ILL, TRAP, ABRT, BUS, FPE, SEGV, SYS    the end of a worker at once, as its own fault is: it makes the
//   outputs
//                                           inactive before it ends, and the guardian does after it. Sent to
//                                           the guardian: stop in good order
#pragma once

#include <csignal>

namespace strobe::firmware {

/// For sigwait(3) and signalfd(2), by whom they must be blocked.
sigset_t worker_stop_signals();
sigset_t guardian_stop_signals();

/// Ignores what is to be ignored, and blocks the guardian's stop signals: before the fork and before any
/// thread.
void set_signal_policy();

/// In the forked worker, before any thread: its own faults end it again. Before that they call `at_fault`, on
/// whichever thread they befall: async-signal-safe calls only. Not those that a sanitizer handles.
void set_worker_signal_policy(void (*at_fault)());

}  // namespace strobe::firmware
