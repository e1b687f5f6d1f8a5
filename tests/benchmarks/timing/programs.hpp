// The shipped programs together, measured: strobe-sim, strobed and strobe fire, from strobed's own journal.
#pragma once

#include <filesystem>
#include <string>

#include "tests/benchmarks/timing/loop_run.hpp"

namespace strobe::benchmarks::timing {

/// Fires dry shots (lamps and shutter only) for about `like.seconds`, with the shipped rig file; a shot with
/// its pauses takes about one. Of `like` only seconds, priority and CPU count. `strobed`: the program, or empty
/// for the one beside this; `time`: strobe-sim's --time. std::runtime_error if no flash was fired.
LoopRun run_programs(const LoopSettings& like, const std::filesystem::path& folder,
                     const std::filesystem::path& strobed = {}, const std::string& time = "real");

}  // namespace strobe::benchmarks::timing
