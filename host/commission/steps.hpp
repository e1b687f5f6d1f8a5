// The steps of commissioning, in their order. Pure; allocates; thread-safe.
#pragma once

#include <memory>
#include <vector>

#include "host/commission/step.hpp"

namespace strobe::commission {

/// Whether the firmware is heard, is the lab's, and has nothing that it cannot do. Moves nothing.
std::unique_ptr<Step> firmware_step();

// Key and e-stop, moved by a person, and a wire of each pulled: what the lines read must follow, and a line
// without its wire must read the safe way. They watch alone; nothing moves.
std::unique_ptr<Step> key_step();
std::unique_ptr<Step> key_wire_step();
std::unique_ptr<Step> estop_step();
std::unique_ptr<Step> estop_wire_step();

// Dry trains, by which lamps, sensors and shutter are judged. The machine's trigger stays inactive.
std::unique_ptr<Step> lamp_step(Lamps lamp);  ///< a or b
std::unique_ptr<Step> lamps_together_step();
std::unique_ptr<Step> shutter_step();

/// The lamps' light on the photograph: five dry shots with photographs.
std::unique_ptr<Step> light_step();
/// The calibration against a printed board: photographs that a person puts into a folder, looked at as they
/// come, on threads of their own. Nothing moves.
std::unique_ptr<Step> board_step();
/// Balls dropped by hand from about a metre, photographed by a slow train. The machine stays still.
std::unique_ptr<Step> drop_step();
/// The machine's trigger, without a ball: one pulse of the right length in a shot, and a click that a person
/// hears.
std::unique_ptr<Step> trigger_step();
/// A few balls thrown by the machine: focus, exposure and linearity of their photographs, flashes against
/// images, scale and squareness by the balls' size, noise, repeatability.
std::unique_ptr<Step> ball_step();

std::vector<std::unique_ptr<Step>> all_steps();

/// Of all of them, in their order: what a record should hold.
std::vector<StepInfo> all_infos();

}  // namespace strobe::commission
