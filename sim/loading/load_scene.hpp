// Scenes from TOML text, by name, or from files. parse_scene() does no I/O but what a resolver does, the
// others read files. For program start: allocates.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// The text of a scene's file; file_name identifies it, and errors name it.
struct SceneText {
  std::string text;
  std::string file_name;
};

/// Finds the scene that `from_file` inherits from by that name. Its error is prefixed with "FILE:LINE:
/// inherits: ".
using SceneResolver = std::function<Result<SceneText>(const std::string& name, const std::string& from_file)>;

/// The longest chain of parents.
inline constexpr std::size_t kMaxAncestors = 16;

/// A scene from its text. With `inherits = "NAME"` it has all that the scene of that name has, except for
/// what its own text says: tables are merged key by key, arrays of tables ([[fault]], [[operator]]) replaced,
/// and of alternatives (the contact's law, e and dwell_ms or springs, the friction's source, alpha or
/// inertia, the tilt) the parent's are dropped where the child has its own, and with ball.kind what the
/// parent says of its ball and its look, its drag and lift, e, dwell_ms and mu. No I/O but what `resolve`
/// does, and ball.kind's file, whose path begins at this scene's folder. The error reads "FILE:LINE:
/// table.key: what is wrong", FILE being that in which the key stands.
Result<Scene> parse_scene(std::string_view text, const std::string& file_name,
                          const SceneResolver& resolve = {});

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
