// Angle and tilt of the dark line around a ball's equator on its images. It is a diameter when the ball spins
// about the line of sight; a tilt shows as half an ellipse, told up to 70 degrees. Seams, print, felt and
// overlapping images are distinguished from it; ambiguous lines are rejected. Deterministic; thread-safe;
// allocates.
#pragma once

#include <span>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// One result for each outline, in their order. `outlines`: of all images, as they may overlap.
std::vector<Measured<Equator>> measure_equators(const Photograph& photograph, const PlaneMap& map,
                                                std::span<const Outline> outlines, Effort effort);

}  // namespace strobe::digitize
