// `strobed --check` on a flash sequencer.
#pragma once

#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/linux/check_item.hpp"

namespace strobe::firmware {

/// sequencer.port, its clock, and what its inputs read. Makes the sequencer cut its outputs. Takes a second
/// at most if it answers.
std::vector<CheckItem> inspect_flash_sequencer(const Rig& rig);

}  // namespace strobe::firmware
