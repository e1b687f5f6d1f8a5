// Runs one command: environment, forwarded signals, exit status.
// For the main thread of a program, before it starts others: signals are blocked in it and in all threads
// after it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"

namespace strobe::sim {

/// Blocks the signals that wait_for_child() handles: SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGCHLD. Call it
/// before any thread is started.
void block_child_signals();

/// Starts `command` (looked up in PATH) with these environment variables set and all others kept. The child
/// is sent SIGTERM if this process dies. Fails if the command cannot be executed. `first`: what the child does before.
Result<int> start_child(const std::vector<std::string>& command,
                        const std::vector<std::pair<std::string, std::string>>& environment,
                        const std::function<void()>& first = {});

/// Waits for the child's end, forwarding SIGINT, SIGTERM, SIGHUP and SIGQUIT (but not those that a terminal
/// sends to the whole foreground, which the child gets anyway). Gives its exit status, or 128 plus the signal that
/// ended it.
int wait_for_child(int pid);

}  // namespace strobe::sim
