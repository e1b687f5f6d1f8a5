// The parts of a bounce. Plain value; real-time safe.
#pragma once

namespace strobe {

/// In the air before the impact, touching the surface, in the air after it.
enum class Leg { incoming, contact, rebound };

}  // namespace strobe
