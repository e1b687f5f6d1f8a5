#include "sim/loading/load_scene.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/config/files.hpp"
#include "sim/loading/tables.hpp"
#include "sim/motion/ball_path.hpp"

namespace strobe::sim {

namespace {

std::string stem(const std::string& file_name) {
  const std::size_t slash = file_name.find_last_of('/');
  std::string base = slash == std::string::npos ? file_name : file_name.substr(slash + 1);
  if (base.size() > 5 && base.ends_with(".toml")) base.resize(base.size() - 5);
  return base;
}

using config::TomlReader;
using config::TomlTable;

struct Key {
  std::string_view table;  ///< "": the root
  std::string_view key;
};

/// One of several alternatives: the keys that select it, and those that are valid only with it.
struct Way {
  std::vector<Key> choosing;
  std::vector<Key> beside{};
};

const std::vector<std::vector<Way>>& alternatives() {
  static const std::vector<std::vector<Way>> all{
      {{{{"machine", "speed_mps"}, {"machine", "angle_deg"}},
        {{"machine", "spin_radps"},
         {"machine", "lag_ms"},
         {"machine", "lateral_deg"},
         {"machine", "lateral_sd_deg"}}},
       {{{"machine", "drop_height_m"}}}},
      {{{{"bounce", "e"}}}, {{{"bounce", "rebound_height_m"}}}},
      {{{{"bounce", "e"}, {"bounce", "rebound_height_m"}, {"bounce", "dwell_ms"}},
        {{"bounce", "e_slope_s_per_m"}}},
       {{{"ball", "stiffness_npm"}, {"ball", "damping_nspm"}}}},
      {{{{"bounce", "mu"}}},
       {{{"surface", "friction"}}},
       {{{"surface", "court_pace"}}},
       {{{"surface", "pace_grade"}}}},
      {{{{"ball", "alpha"}}}, {{{"ball", "inertia"}}}},
      {{{{"", "surface_angle_deg"}}}, {{{"surface", "tilt_deg"}}}},
  };
  return all;
}

std::vector<Key> keys_of(std::string_view law) {
  std::vector<Key> keys;
  for (const std::string_view key : tables::keys_of(law == "grip" ? ContactLaw::grip : ContactLaw::ode))
    keys.push_back({"bounce", key});
  return keys;
}

bool has(TomlReader& document, const Key& key) {
  TomlTable root = document.root();
  return key.table.empty() ? root.has(key.key)
                           : root.is_table(key.table) && root.table(key.table).has(key.key);
}

bool has_any(TomlReader& document, const std::vector<Key>& keys) {
  return std::ranges::any_of(keys, [&](const Key& key) { return has(document, key); });
}

void drop(TomlReader& document, const std::vector<Key>& keys) {
  for (const Key& key : keys) document.remove(key.table, key.key);
}

std::string law_of(TomlReader& document) {
  TomlTable root = document.root();
  if (!has(document, {"bounce", "contact"}) || !root.table("bounce").is_string("contact")) return "ode";
  return root.table("bounce").string("contact");
}

/// Removes from the parent the alternatives that the child replaces, and all that another kind of ball
/// brings.
void drop_overridden(TomlReader& child, TomlReader& parent) {
  if (has(child, {"ball", "kind"})) {
    for (const std::string_view key :
         {"diameter_m", "mass_kg", "alpha", "inertia", "stiffness_npm", "damping_nspm"})
      parent.remove("ball", key);
    for (const std::string_view key : {"drag_coefficient", "lift_law", "lift_factor", "spin_decay_per_m"})
      parent.remove("air", key);
    for (const std::string_view key : {"e", "rebound_height_m", "dwell_ms", "mu"})
      parent.remove("bounce", key);
    for (const std::string_view key :
         {"surface", "line", "albedo", "shine", "seam_contrast", "logo_contrast"})
      parent.remove("ball_appearance", key);
  }
  for (const std::vector<Way>& ways : alternatives()) {
    for (const Way& chosen : ways) {
      if (!has_any(child, chosen.choosing)) continue;
      for (const Way& other : ways) {
        if (&other == &chosen) continue;
        drop(parent, other.choosing);
        drop(parent, other.beside);
      }
    }
  }
  if (has(child, {"bounce", "contact"}) && law_of(child) != law_of(parent))
    drop(parent, keys_of(law_of(parent)));
}

class Chain {
 public:
  explicit Chain(const SceneResolver& resolve) : resolve_(resolve) {}

  Result<TomlReader> merge(TomlReader child, const std::string& file_name) {
    files_.push_back(file_name);
    TomlTable root = child.root();
    if (!root.has("inherits")) return child;
    const std::string parent_name = root.string("inherits");
    if (auto bad = child.error_so_far()) return tl::unexpected(*bad);
    auto parent = parent_of(parent_name, file_name);
    if (!parent) return refused(child, root, parent.error().message);
    TomlReader document(parent->text, parent->file_name);
    if (auto bad = document.error_so_far()) return tl::unexpected(*bad);
    auto whole = merge(std::move(document), parent->file_name);
    if (!whole) return whole;
    drop_overridden(child, *whole);
    child.inherit(std::move(*whole));
    return child;
  }

 private:
  Result<SceneText> parent_of(const std::string& name, const std::string& file_name) const {
    if (!resolve_) return fail("no other scenes can be read here");
    if (files_.size() > kMaxAncestors)
      return fail("more than " + std::to_string(kMaxAncestors) + " scenes inherit from each other");
    auto parent = resolve_(name, file_name);
    if (parent && std::ranges::find(files_, parent->file_name) != files_.end())
      return fail(parent->file_name + " inherits from itself");
    return parent;
  }

  static Result<TomlReader> refused(TomlReader& child, TomlTable& root, const std::string& what) {
    root.error_at("inherits", what);
    return tl::unexpected(*child.error_so_far());
  }

  const SceneResolver& resolve_;
  std::vector<std::string> files_;
};

/// The document merged with the chain of parents that its key `inherits` begins.
Result<TomlReader> with_inherited(TomlReader child, const std::string& file_name,
                                  const SceneResolver& resolve) {
  if (auto bad = child.error_so_far()) return tl::unexpected(*bad);
  return Chain(resolve).merge(std::move(child), file_name);
}

namespace fs = std::filesystem;

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

Result<Scene> parse_scene(std::string_view text, const std::string& file_name, const SceneResolver& resolve) {
  auto reader = with_inherited(config::TomlReader(text, file_name), file_name, resolve);
  if (!reader) return tl::unexpected(reader.error());
  config::TomlTable root = reader->root();
  Scene scene;
  scene.name = stem(file_name);
  scene.parent = root.string_or("inherits", "");
  scene.title = root.string_or("title", scene.name);
  tables::read_tilt(root, scene);
  tables::read_ball(root, fs::path(file_name).parent_path(), scene);
  scene.air = tables::read_air(root.table("air"), scene.kind);
  tables::read_machine(root, scene);
  tables::read_impact(root, scene);
  scene.lamps = tables::read_lamps(root.table("lamps"));
  scene.sensors = tables::read_sensors(root.table("sensors"));
  scene.shutter = tables::read_shutter(root.table("shutter"));
  scene.hand = tables::read_hand(root.table("hand"));
  scene.gate.distance_m = root.table("gate").number_or("distance_m", scene.gate.distance_m, {0.1, 20.0});
  scene.camera = tables::read_camera(root.table("camera"), scene.ball);
  scene.camera_link = tables::read_camera_link(root.table("camera_link"));
  scene.tablet = tables::read_tablet(root.table("tablet"));
  scene.photograph = tables::read_photograph(root.table("photograph"));
  scene.ball_appearance = tables::read_ball_appearance(root.table("ball_appearance"), scene.kind);
  scene.background = tables::read_background(root.table("background"));
  scene.readout = tables::read_readout(root.table("readout"));
  scene.chip = tables::read_chip(root.table("chip"));
  for (config::TomlTable& table : root.tables("operator"))
    scene.operator_actions.push_back(tables::read_action(table));
  scene.faults = read_faults(root);
  if (auto bad = reader->error()) return tl::unexpected(*bad);
  if (const auto path = BallPath::make(scene, draw_shot_conditions(without_spread(scene), 1, 1)); !path) {
    root.table("machine").error_at("speed_mps", "the mean ball cannot bounce: " + path.error().message);
    return tl::unexpected(*reader->error());
  }
  return scene;
}

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
