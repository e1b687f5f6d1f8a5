// Whether a match of images to flashes is one that a ball can have flown. No I/O; thread-safe; allocates.
#pragma once

#include "host/assembly/flash_match.hpp"
#include "host/assembly/track.hpp"

namespace strobe::host {

/// How far the images are from steady flight at the times of their flashes, rms of a coordinate [px]; 0 where too few
/// images leave that open, infinite where no steady flight leads to flashes at all.
double off_steady_px(const Track& track, const FlashMatch& match);

/// False where the images are further off than a lens that no calibration undoes bends a flight: the assignment to legs
/// or flashes is then wrong, and so is every number.
bool is_steady(const Track& track, const FlashMatch& match);

}  // namespace strobe::host
