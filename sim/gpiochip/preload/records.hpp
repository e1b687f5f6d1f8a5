// Reads of events and of what changed on watched lines: whole records only, as from the kernel.
#pragma once

#include <cstddef>

namespace strobe::sim::gpio {

/// A read of that size can only take whole records, whatever it reads, of a device that is there: nothing to
/// look for.
bool is_whole_for_all(std::size_t size);

/// Bytes that a read of `size` takes at most, or a negated errno.
long whole_records(int fd, std::size_t size);

}  // namespace strobe::sim::gpio
