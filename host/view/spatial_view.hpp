// What a shot tells of the third dimension (reduction::Spatial), for a person. Pure; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"

namespace strobe::host {

/// With two digits of its total standard uncertainty: "12.3 ± 0.4"; "-" of what is not told.
std::string value_and_sd(const std::optional<reduction::DerivedNumber>& number);

/// Whether the spin's axis is off the camera's: by more than 2 sd, and flagged or by more than a degree.
bool is_axis_tilted(const reduction::Readout& readout);

/// A sentence on the spin's axis where it is tilted, and one on the velocity towards the camera where that is
/// not zero: flagged, or by more than 3 sd. Else none.
std::vector<std::string> spatial_words(const reduction::Readout& readout);

/// The ball before and after the bounce with its spin's axis, as an SVG; empty where the axis is not tilted.
std::string spin_drawing(const reduction::Readout& readout);

}  // namespace strobe::host
