// Names and units of a readout's quantities for a person. Constants.
#pragma once

#include <array>
#include <string_view>

#include "common/reduction/readout.hpp"

namespace strobe::host {

struct QuantityLabel {
  std::string_view words;
  std::string_view unit;
};

/// In the order of reduction::Quantity.
inline constexpr std::array<QuantityLabel, reduction::kQuantityCount> kQuantityLabels{{
    {"angle in", "deg"},
    {"angle out", "deg"},
    {"vx touchdown", "m/s"},
    {"vy touchdown", "m/s"},
    {"speed touchdown", "m/s"},
    {"spin touchdown", "rad/s"},
    {"vx lift-off", "m/s"},
    {"vy lift-off", "m/s"},
    {"speed lift-off", "m/s"},
    {"spin lift-off", "rad/s"},
    {"slip lift-off", "m/s"},
    {"restitution e", ""},
    {"impulse ratio mu", ""},
    {"dwell time", "ms"},
    {"dwell distance", "cm"},
    {"court pace", ""},
}};

}  // namespace strobe::host
