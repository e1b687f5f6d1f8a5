// The lines of the simulated rig's chip: their names and offsets. Values only.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace strobe::sim {

/// Offsets of the wired lines. All are active high but ESTOP, which is low while pressed or disconnected.
enum class RigLine : std::uint32_t {
  strobe_a,
  strobe_b,
  shutter,
  trigger,
  sensor_a,
  sensor_b,
  gate,
  key,
  estop,
  xsync,
};

inline constexpr std::array<std::string_view, 16> kLineNames{
    "STROBE_A", "STROBE_B", "SHUTTER",  "TRIGGER",  "SENSOR_A", "SENSOR_B", "GATE",     "KEY",
    "ESTOP",    "XSYNC",    "SPARE_10", "SPARE_11", "SPARE_12", "SPARE_13", "SPARE_14", "SPARE_15"};
inline constexpr std::size_t kWiredLines = 10;

constexpr std::string_view name(RigLine line) { return kLineNames[static_cast<std::size_t>(line)]; }

constexpr std::optional<RigLine> rig_line(std::uint32_t offset) {
  if (offset >= kWiredLines) return std::nullopt;
  return static_cast<RigLine>(offset);
}

constexpr std::optional<RigLine> rig_line(std::string_view line_name) {
  for (std::size_t i = 0; i < kWiredLines; ++i) {
    if (kLineNames[i] == line_name) return static_cast<RigLine>(i);
  }
  return std::nullopt;
}

}  // namespace strobe::sim
