// Starts programs that see a chip's folder as a GPIO chip of the machine and live in its rig's time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"

namespace strobe::sim {

/// start_child() with the library beside this program preloaded. `join`: makes the child take part in rig time.
Result<int> start_joined(const std::vector<std::string>& command, const std::filesystem::path& chip_folder,
                         const std::function<void()>& join);

/// The chip of a rig that may have been started just before: waits for it, ten seconds at most.
Result<Chip> attach_to_rig(const std::filesystem::path& chip_folder);

}  // namespace strobe::sim
