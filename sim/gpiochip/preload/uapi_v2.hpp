// The kernel's GPIO uAPI v2 on the simulated chip, and line-info watches of v1 and v2. Every function returns
// what the system call would: 0 or a negated errno.
#pragma once

#include <cstdint>

namespace strobe::sim::gpio {

int line_info_v2(void* user);

int get_line_values(std::uint32_t slot, void* user);
int set_line_values(std::uint32_t slot, const void* user);

/// `watcher`: of the descriptor; kMaxWatchers if it cannot watch.
int watch_line(std::uint32_t watcher, void* user);
int watch_line_v1(std::uint32_t watcher, void* user);
int unwatch_line(std::uint32_t watcher, const void* user);

}  // namespace strobe::sim::gpio
