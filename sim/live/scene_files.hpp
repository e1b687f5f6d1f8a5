// Scenes by name or by file. Reads files; call it at start.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "sim/rig/scene.hpp"

namespace strobe::sim {

/// Folder of the data that come with the program: $STROBE_SHARE, else ../share/strobe beside the executable's
/// folder.
Result<std::filesystem::path> share_folder();

/// A scene of the scenes' folder by its name (zero_23), or any file (with a slash or ending in .toml) by its
/// path.
Result<Scene> load_scene(const std::string& name_or_path);

/// Every scene of the scenes' folder, by spin and then by angle. Fails at the first that cannot be read.
Result<std::vector<Scene>> shipped_scenes();

Result<std::string> read_text_file(const std::filesystem::path& path);

}  // namespace strobe::sim
