// `strobed --check` on the chip and its lines.
#pragma once

#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/linux/check_item.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

/// chip.name and chip.bus, then each line, e.g. lines.strobe_a, and the bias of inputs, e.g. lines.key.bias.
/// Outputs are neither requested nor changed; inputs that nobody uses are requested for some milliseconds
/// with the bias that strobed sets.
std::vector<CheckItem> inspect_lines(const Rig& rig, const SystemFiles& files);

}  // namespace strobe::firmware
