#include "sim/loading/scene_files.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "common/config/files.hpp"
#include "sim/loading/parse_scene.hpp"

namespace strobe::sim {

namespace fs = std::filesystem;

namespace {

bool is_path(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".toml");
}

Result<fs::path> shipped_scene_path(const std::string& name) {
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  const fs::path path = *share / "scenes" / (name + ".toml");
  std::error_code error;
  if (!fs::exists(path, error))
    return fail("no scene \"" + name + "\" (strobe-sim scenes lists them; a file's path ends in .toml)");
  return path;
}

Result<fs::path> parent_path(const std::string& name, const fs::path& from_file) {
  if (is_path(name)) return from_file.parent_path() / name;
  const fs::path sibling = from_file.parent_path() / (name + ".toml");
  std::error_code error;
  if (fs::exists(sibling, error)) return sibling;
  return shipped_scene_path(name);
}

}  // namespace

Result<SceneText> resolve_scene(const std::string& name, const std::string& from_file) {
  const auto path = parent_path(name, from_file);
  if (!path) return tl::unexpected(path.error());
  const fs::path normal = path->lexically_normal();
  return config::read_file(normal.string()).map([&](std::string text) {
    return SceneText{std::move(text), normal.string()};
  });
}

Result<Scene> load_scene(const std::string& name_or_path) {
  fs::path path = name_or_path;
  if (!is_path(name_or_path)) {
    const auto shipped = shipped_scene_path(name_or_path);
    if (!shipped) return tl::unexpected(shipped.error());
    path = *shipped;
  }
  const auto text = config::read_file(path.string());
  if (!text) return tl::unexpected(text.error());
  return parse_scene(*text, path.string(), resolve_scene);
}

Result<std::vector<SceneFile>> shipped_scene_files() {
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  std::error_code error;
  std::vector<SceneFile> scenes;
  for (const auto& entry : fs::directory_iterator(*share / "scenes", error)) {
    if (entry.path().extension() == ".toml")
      scenes.push_back({entry.path().stem().string(), load_scene(entry.path().string())});
  }
  if (error) return fail((*share / "scenes").string() + ": " + error.message());
  std::ranges::sort(scenes, {},
                    [](const SceneFile& s) { return std::pair(s.name.substr(0, s.name.find('_')), s.name); });
  return scenes;
}

}  // namespace strobe::sim
