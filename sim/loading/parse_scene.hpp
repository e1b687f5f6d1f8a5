// Scenes from TOML text. Allocates; no I/O but what a resolver does.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

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
/// inertia, the tilt) the parent's are dropped where the child has its own. No I/O but what `resolve` does.
/// The error reads "FILE:LINE: table.key: what is wrong", FILE being that in which the key stands.
Result<Scene> parse_scene(std::string_view text, const std::string& file_name,
                          const SceneResolver& resolve = {});

}  // namespace strobe::sim
