// The parts of a bounce. Plain value; real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace strobe {

/// In the air before the impact, touching the surface, in the air after it.
enum class Leg { incoming, contact, rebound };
inline constexpr std::array<std::string_view, 3> kLegNames{"incoming", "contact", "rebound"};

constexpr std::string_view name(Leg leg) { return kLegNames[static_cast<std::size_t>(leg)]; }

}  // namespace strobe
