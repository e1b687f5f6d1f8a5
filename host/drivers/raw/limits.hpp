// What this process may take of the machine, before it opens a file: decoders meet hostile bytes.
#pragma once

namespace strobe::raw {

/// Memory, time, the size of files; no core, no further processes. Out of time the process ends with status 1
/// and one line. Returns false if the system refuses.
bool limit_this_process();

}  // namespace strobe::raw
