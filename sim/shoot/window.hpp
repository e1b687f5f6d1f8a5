// How long the balls of a scene are in the camera's view. Pure; thread-safe.
#pragma once

#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// Around the instant at which the mean ball meets the plate. [s]
struct Window {
  double before_s = 0.0;
  double after_s = 0.0;
};

/// From the scene's mean ball, with margins for the spread of speed, angle and the machine's lag at
/// kLargestNormal standard deviations, and a flash's period on either side. Each side at most 0.25 s before
/// lag and period are added. A ball that comes back into view, falling, is not waited for.
Window crossing_window(const Scene& scene, double period_s);

}  // namespace strobe::sim
