#include "sim/loading/scene_files.hpp"
#include "sim/loading/parse_scene.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <system_error>

namespace strobe::sim {

namespace fs = std::filesystem;

Result<std::string> read_text_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return fail(path.string() + ": is a folder");
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(path.string() + ": cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad() || text.bad()) return fail(path.string() + ": cannot be read");
  return text.str();
}

Result<fs::path> share_folder() {
  std::error_code error;
  fs::path folder;
  if (const char* given = std::getenv("STROBE_SHARE"); given && *given) {
    folder = given;
  } else {
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    if (error) return fail("cannot find the program's own folder: " + error.message());
    folder = self.parent_path().parent_path() / "share" / "strobe";
  }
  if (!fs::is_directory(folder, error))
    return fail(folder.string() + ": no such folder (STROBE_SHARE names the one with the scenes)");
  return folder;
}

namespace {

bool is_path(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".toml");
}

Result<fs::path> shipped_scene_path(const std::string& name) {
  const auto share = share_folder();
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
  return read_text_file(normal).map([&](std::string text) {
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
  const auto text = read_text_file(path);
  if (!text) return tl::unexpected(text.error());
  return parse_scene(*text, path.string(), resolve_scene);
}

Result<std::vector<SceneFile>> shipped_scene_files() {
  const auto share = share_folder();
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

Result<std::vector<Scene>> shipped_scenes() {
  auto files = shipped_scene_files();
  if (!files) return tl::unexpected(files.error());
  std::vector<Scene> scenes;
  for (SceneFile& file : *files) {
    if (!file.scene) return tl::unexpected(file.scene.error());
    scenes.push_back(std::move(*file.scene));
  }
  return scenes;
}

}  // namespace strobe::sim
