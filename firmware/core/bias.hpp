// What a chip's own resistor does to an input, and which one makes a broken wire stop the rig.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

enum class Bias {
  as_is,  ///< as whoever had the line before left it; after a reset, as the chip's maker chose for that line
  pull_up,
  pull_down,
  disabled,
};

/// As in the rig file.
inline constexpr std::array<std::string_view, 4> kBiasNames{"as_is", "pull_up", "pull_down", "disabled"};
constexpr std::string_view name(Bias bias) { return kBiasNames[static_cast<std::size_t>(bias)]; }

constexpr bool pulls(Bias bias) { return bias == Bias::pull_up || bias == Bias::pull_down; }
/// Of one that pulls.
constexpr Bias opposite(Bias bias) { return bias == Bias::pull_up ? Bias::pull_down : Bias::pull_up; }

/// Pulls an open wire to where the e-stop reads as pressed, or the key as off; nullopt for a line whose broken wire
/// stops nothing.
constexpr std::optional<Bias> fail_safe_bias(Line line, bool active_low) {
  if (line == Line::estop) return active_low ? Bias::pull_down : Bias::pull_up;
  if (line == Line::key) return active_low ? Bias::pull_up : Bias::pull_down;
  return std::nullopt;
}

}  // namespace strobe::firmware
