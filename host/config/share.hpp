// Where the files that come with the program are: scenes, the thesis's tables, the example rig file.
// Reads the environment and /proc; call it at start, from one thread.
#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace strobe::host {

/// $STROBE_SHARE if set, else ../share/strobe beside the executable's folder.
/// Fails if that folder does not exist; the message names it.
Result<std::filesystem::path> share_folder();

}  // namespace strobe::host
