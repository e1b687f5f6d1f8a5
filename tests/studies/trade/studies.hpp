// The studies, each measured when called: seconds. One thread's; figures of cost want a quiet machine.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/studies/trade/study.hpp"

namespace strobe::studies::trade {

/// Velocities and spin at lift-off over the practical range, and within the spread of one scene.
std::vector<Study> lift_off_studies(const Effort& effort);

/// Place and rotation during contact.
Study course_study(const Effort& effort);

Study flight_study(const Effort& effort);

/// Noise stated, and estimated from the shot.
std::vector<Study> estimator_studies(const Effort& effort);

/// Nothing if the scenes that come with the program cannot be read.
std::optional<Study> shot_study(const Effort& effort);

/// Engines that are not installed are named in `missing`.
Study engine_study(const Effort& effort, std::vector<std::string>& missing);

}  // namespace strobe::studies::trade
