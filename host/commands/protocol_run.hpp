// Fires what a protocol asks for, block by block: between blocks a person changes ball or place and says so.
// What is left is always told from the session's own shots, so that a run that ended anyhow is gone on with.
// Single-threaded; blocks until all is fired or a person ends it.
#pragma once

#include <functional>

#include "host/clock/machine_clock.hpp"
#include "host/commands/fire_run.hpp"

namespace strobe::host {

/// Fires one block as `strobe fire` fires a series; asked: when a person gave the command. Returns the exit
/// status.
using FireBlock = std::function<int(const FireOptions& options, const HostReading& asked)>;

/// asked: when the command was given, which is the person's word for the first block. Returns the exit
/// status: kDone only where the protocol's requirements are met.
int run_protocol(const FireOptions& options, const HostReading& asked, const FireBlock& fire);

}  // namespace strobe::host
