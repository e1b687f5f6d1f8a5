// Faults of the simulated rig, shot by shot: a scene's [[fault]] tables.
// Plain values and pure functions: thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "common/config/toml_reader.hpp"
#include "common/units/time.hpp"

namespace strobe::sim {

enum class FaultKind {
  flash_late,        ///< the lamp flashes delay_us later than it should
  flash_missing,     ///< the lamp does not flash
  flash_double,      ///< the lamp flashes again delay_us after its flash
  flash_dim,         ///< the flash is too weak for the camera, not for the sensor
  lamp_dead,         ///< no flash in the whole shot
  sensor_dead,       ///< no edge of the sensor in the whole shot
  sensor_dropout,    ///< the sensor does not see this flash
  sensor_bounce,     ///< the sensor's line drops briefly: a second edge delay_us after the first
  gate_chatter,      ///< three false interruptions of the gate, delay_us apart, before the ball
  shutter_stuck,     ///< the shutter does not open
  ball_misses,       ///< the ball passes the gate but misses the plate and the camera's view
  machine_misfire,   ///< the machine does not throw
  no_photograph,     ///< the photograph is not digitized
  frame_late,        ///< the frame is sent delay_s late
  image_unseen,      ///< the tablet operator overlooks this flash's image
  gate_dead,         ///< the gate does not see the ball
  machine_double,    ///< the machine throws a second ball, alike, delay_us after the first
  frame_dropped,     ///< the camera exposes, but nothing of the frame is sent
  frame_incomplete,  ///< packets of the frame are lost, however often they are asked for
  frame_twice,       ///< the camera sends the photograph as two frames
  camera_auto,       ///< the camera sets exposure and gain by itself from now on
  camera_vanishes,   ///< the camera is gone for delay_s, the photograph with it, and switched on anew
  card_full,         ///< from this exposure on the camera's card has no room
  battery_low,       ///< from this exposure on the camera's battery is nearly empty
};

inline constexpr std::array<std::string_view, 24> kFaultNames{
    "flash_late",  "flash_missing",   "flash_double",  "flash_dim",        "lamp_dead",
    "sensor_dead", "sensor_dropout",  "sensor_bounce", "gate_chatter",     "shutter_stuck",
    "ball_misses", "machine_misfire", "no_photograph", "frame_late",       "image_unseen",
    "gate_dead",   "machine_double",  "frame_dropped", "frame_incomplete", "frame_twice",
    "camera_auto", "camera_vanishes", "card_full",     "battery_low"};

constexpr std::string_view name(FaultKind kind) { return kFaultNames[static_cast<std::size_t>(kind)]; }

enum class Lamp { a, b };

struct Fault {
  FaultKind kind = FaultKind::flash_late;
  int shot = 0;                            ///< exposure it concerns, 1-based; 0: every one
  std::optional<int> flash_from_impact{};  ///< -1: last flash before touchdown, 1: first after; never 0
  std::optional<int> flash_index{};        ///< alternatively the flash's number within the exposure, 0-based
  bool lamp_a = true;                      ///< which lamp or sensor it concerns
  bool lamp_b = true;
  Duration delay{};  ///< flash_late, flash_double, sensor_bounce, gate_chatter, frame_late, machine_double,
                     ///< camera_vanishes

  bool concerns(Lamp lamp) const { return lamp == Lamp::a ? lamp_a : lamp_b; }
};

/// The [[fault]] tables of a scene; errors are reported to the tables' reader.
std::vector<Fault> read_faults(config::TomlTable& scene);

/// Which flash: its exposure, and its number counted from the first and from the impact (absent without a
/// ball).
struct FlashPlace {
  int shot = 0;
  int index = 0;
  std::optional<int> from_impact{};
};

/// First fault of a per-flash kind for this flash of this lamp; nullptr if there is none.
const Fault* flash_fault(const std::vector<Fault>& faults, FaultKind kind, const FlashPlace& place,
                         Lamp lamp);

/// First fault of a per-shot kind in this shot (and for this lamp or sensor); nullptr if there is none.
const Fault* shot_fault(const std::vector<Fault>& faults, FaultKind kind, int shot);
const Fault* shot_fault(const std::vector<Fault>& faults, FaultKind kind, int shot, Lamp lamp);

}  // namespace strobe::sim
