// The forms by subject; each group in the file of its name.
#pragma once

#include <vector>

#include "tests/common/numerics/forms/digits.hpp"

namespace strobe::numerics {

std::vector<Form> unit_forms();       ///< ball, angles
std::vector<Form> impact_forms();     ///< in/out models
std::vector<Form> pulse_forms();      ///< damped sine pulse
std::vector<Form> flight_forms();     ///< parabola, drag and lift
std::vector<Form> reduction_forms();  ///< surface frame, readouts and their derivatives, court pace
std::vector<Form> contact_forms();    ///< cubics, springs

}  // namespace strobe::numerics
