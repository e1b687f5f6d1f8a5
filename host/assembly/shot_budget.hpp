// The uncertainty budget of a photograph whose flashes were matched. Deterministic, no I/O; thread-safe; allocates; some
// milliseconds.
#pragma once

#include "common/reduction/budget.hpp"
#include "host/assembly/assemble.hpp"

namespace strobe::host {

/// Of `readout`, the shot's: of the likeliest assignment of flashes to images, with a line for the others. Of plausible
/// ones there are more than one only where they are nearly alike, so that the other lines are those of all, scaled to the
/// mixture's variance. Empty for a shot without a frame that can be reduced.
reduction::Budget shot_budget(const AssembledShot& shot, const reduction::Readout& readout);

}  // namespace strobe::host
