// True values of an exposure, for tests and studies. Thread-safe;
// allocates.
#pragma once

#include <string>

#include "common/reduction/readout.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

/// True values of every quantity of a readout, from the ball's true state at touchdown and lift-off.
reduction::Quantities true_readout(const Scene& scene, const BallPath& path);

/// Likewise what only a motion out of the plane has, without standard deviations.
reduction::Spatial true_spatial(const BallPath& path);

/// One JSON object on one line, without the newline:
///   shot          number of the exposure, 1-based; 0: the shot made none
///   shot_id       the firmware's number; 0: it never said
///   ball          whether a ball met the plate while the shutter was open
///   throws        how often the machine threw for this shot
///   touchdown_ns, liftoff_ns, readout       null without a ball
///   spatial       true_spatial() by its names; only of a shot that is not planar
///   opened_ns, closed_ns                    of the shutter; null: it did not open
///   flash_true_ns                           for each strobe pulse the mean of its flashes; null: none
///   image_flash                             for each digitized image the index of its pulse
///   faults                                  kinds that occurred
///   overrun                                  the simulation itself could not keep up with real time
std::string truth_line(const Scene& scene, const Exposure& exposure, int shot_id);

}  // namespace strobe::sim
