// What every flash lights besides the ball: the wall with the balls' soft shadows, the plate, and other
// objects. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/photograph/lit_balls.hpp"

namespace strobe::sim {

/// The light of all flashes together, CV_32FC1 of the sensor's size. `light_of_all`: of each lamp.
cv::Mat render_background(const Scene& scene, const Appearance& appearance,
                          const std::vector<BallImageOnSensor>& images,
                          const std::array<double, 2>& light_of_all);

}  // namespace strobe::sim
