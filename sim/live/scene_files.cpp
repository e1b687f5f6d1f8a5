#include "sim/live/scene_files.hpp"

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

Result<Scene> load_scene(const std::string& name_or_path) {
  const bool is_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".toml");
  fs::path path = name_or_path;
  if (!is_path) {
    const auto share = share_folder();
    if (!share) return tl::unexpected(share.error());
    path = *share / "scenes" / (name_or_path + ".toml");
    std::error_code error;
    if (!fs::exists(path, error))
      return fail("no scene \"" + name_or_path +
                  "\" (strobe-sim scenes lists them; a file's path ends in .toml)");
  }
  const auto text = read_text_file(path);
  if (!text) return tl::unexpected(text.error());
  return parse_scene(*text, path.string());
}

Result<std::vector<Scene>> shipped_scenes() {
  const auto share = share_folder();
  if (!share) return tl::unexpected(share.error());
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(*share / "scenes", error)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  }
  if (error) return fail((*share / "scenes").string() + ": " + error.message());
  std::vector<Scene> scenes;
  for (const fs::path& file : files) {
    auto scene = load_scene(file.string());
    if (!scene) return tl::unexpected(scene.error());
    scenes.push_back(std::move(*scene));
  }
  std::ranges::sort(scenes, {},
                    [](const Scene& s) { return std::pair(s.name.substr(0, s.name.find('_')), s.name); });
  return scenes;
}

}  // namespace strobe::sim
