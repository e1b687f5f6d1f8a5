// The thesis's series of a spin and an angle. Reads the file that comes with strobe; thread-safe.
#pragma once

#include <optional>
#include <string>

#include "common/data/thesis_data.hpp"

namespace strobe::host {

/// Tables 2-10 have one of that spin and that angle of incidence, which they label without sign. Returns nullopt if not.
std::optional<thesis::Condition> thesis_condition(const std::string& spin, double angle_deg);

}  // namespace strobe::host
