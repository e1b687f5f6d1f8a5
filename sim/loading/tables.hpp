// Reads a scene's tables, one function each: names of keys, units, ranges. Errors are reported to the tables'
// reader. Implementation of load_scene.hpp; allocates.
#pragma once

#include <filesystem>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>

#include "common/config/toml_reader.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim::tables {

inline constexpr double kDegree = std::numbers::pi / 180.0;
inline constexpr double kMilli = 1e-3;
inline constexpr double kMicro = 1e-6;

/// Keys of [bounce] that only that law has.
std::span<const std::string_view> keys_of(ContactLaw law);

// impact_tables.cpp: ball, machine and contact. Each needs those before it in the scene, and [air] for
// the surface's speed.
/// `folder`: where a path of ball.kind begins.
void read_ball(config::TomlTable& root, const std::filesystem::path& folder, Scene& scene);
void read_machine(config::TomlTable& root, Scene& scene);
void read_impact(config::TomlTable& root, Scene& scene);  ///< [bounce], and springs and friction elsewhere
void read_tilt(config::TomlTable& root, Scene& scene);

// rig_tables.cpp: the rig.
AirSettings read_air(config::TomlTable table, const std::optional<balls::Kind>& kind);
LampSettings read_lamps(config::TomlTable table);
SensorSettings read_sensors(config::TomlTable table);
ShutterSettings read_shutter(config::TomlTable table);
HandSettings read_hand(config::TomlTable table);
CameraSettings read_camera(config::TomlTable table, const ball::Ball& ball);
CameraLinkSettings read_camera_link(config::TomlTable table);
TabletSettings read_tablet(config::TomlTable table);
ReadoutSettings read_readout(config::TomlTable table);
ChipSettings read_chip(config::TomlTable table);
OperatorAction read_action(config::TomlTable& table);

// photograph_tables.cpp: the photographs.
PhotographSettings read_photograph(config::TomlTable table);
/// Without a key of its own the surface is what the kind of ball says, and a line is drawn where that says
/// so.
BallAppearanceSettings read_ball_appearance(config::TomlTable table, const std::optional<balls::Kind>& kind);
BackgroundSettings read_background(config::TomlTable table);

}  // namespace strobe::sim::tables
