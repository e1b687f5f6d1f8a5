// Loads scenes by name or by path. Reads files; for program start.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "sim/loading/parse_scene.hpp"

namespace strobe::sim {

/// A scene of the scenes' folder by its name (zero_23), or any file (with a slash or ending in .toml) by its
/// path.
Result<Scene> load_scene(const std::string& name_or_path);

/// The scene that `from_file` inherits from: by a path relative to its folder, or by name from that folder or
/// from the scenes' folder.
Result<SceneText> resolve_scene(const std::string& name, const std::string& from_file);

/// A file of the scenes' folder: its scene, or the error in it.
struct SceneFile {
  std::string name;
  Result<Scene> scene;
};

/// By the name's first word and then by name. Fails if the folder cannot be read.
Result<std::vector<SceneFile>> shipped_scene_files();

}  // namespace strobe::sim
