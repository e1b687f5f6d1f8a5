#include "sim/loading/parse_scene.hpp"

#include "sim/loading/inheritance.hpp"
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
  tables::read_ball(root, scene);
  tables::read_machine(root, scene);
  scene.air = tables::read_air(root.table("air"));
  tables::read_impact(root, scene);
  scene.lamps = tables::read_lamps(root.table("lamps"));
  scene.sensors = tables::read_sensors(root.table("sensors"));
  scene.shutter = tables::read_shutter(root.table("shutter"));
  scene.hand = tables::read_hand(root.table("hand"));
  scene.gate.distance_m = root.table("gate").number_or("distance_m", scene.gate.distance_m, {0.1, 20.0});
  scene.camera = tables::read_camera(root.table("camera"), scene.ball);
  scene.tablet = tables::read_tablet(root.table("tablet"));
  scene.photograph = tables::read_photograph(root.table("photograph"));
  scene.ball_appearance = tables::read_ball_appearance(root.table("ball_appearance"));
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

}  // namespace strobe::sim
