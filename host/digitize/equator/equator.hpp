// The angle of the dark line through the middle of a ball's image. It is a diameter when the ball turns about
// the line of sight; a line tilted by up to 5 degrees shows as half an ellipse. Seams, print, felt and the
// images of other balls that lie over it are not mistaken for it: what is not clear is said, not guessed.
// Deterministic; thread-safe; allocates.
#pragma once

#include <span>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// One result for each outline, in their order; the outlines of all images are needed, as they overlap.
std::vector<Measured<Equator>> measure_equators(const Photograph& photograph, const PlaneMap& map,
                                                std::span<const Outline> outlines, Effort effort);

}  // namespace strobe::digitize
