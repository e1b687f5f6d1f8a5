// Flashes of strobed's journal as samples.
#pragma once

#include <optional>
#include <strobe_msgs/event_t.hpp>

#include "tests/benchmarks/timing/sample.hpp"

namespace strobe::benchmarks::timing {

/// A flash's issue; also of one that was too late to be issued, for which its shot was aborted: it counts as
/// issued then, since the latest flashes would be missing otherwise. Returns nullopt for all other events.
std::optional<Sample> flash_of(const strobe_msgs::event_t& event, int cpu);

}  // namespace strobe::benchmarks::timing
