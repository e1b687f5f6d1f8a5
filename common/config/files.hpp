// Whole small files: what a person wrote, what comes with the programs, what they keep. Reads and writes files,
// reads the environment and /proc; call it from one thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::config {

/// The whole file as text, at most 16 MB. "-" is standard input. Fails with the file's name.
Result<std::string> read_file(const std::string& path);

/// Fails with the file's name.
Result<void> write_file(const std::filesystem::path& path, std::string_view text);

/// Where scenes, the thesis's tables and the example rig file are: $STROBE_SHARE if set, else
/// ../share/strobe beside the executable's folder. Fails if that folder does not exist; the message names it.
Result<std::filesystem::path> share_folder();

}  // namespace strobe::config
