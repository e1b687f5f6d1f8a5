#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/messages/parsed_json.hpp"
#include "sim/commands/commands.hpp"
#include "sim/loading/scene_files.hpp"
#include "sim/scene/spring.hpp"

namespace strobe::sim {

namespace {

void print_json(const SceneFile& file) {
  if (!file.scene) {
    const nlohmann::json line = {{"scene", file.name}, {"error", file.scene.error().message}};
    fmt::print("{}\n", messages::json_text(line));
    return;
  }
  const Scene& scene = *file.scene;
  nlohmann::json line = {{"scene", scene.name},
                         {"title", scene.title},
                         {"inherits", nullptr},
                         {"contact", scene.bounce.contact == ContactLaw::ode ? "ode" : "grip"},
                         {"speed_mps", scene.machine.speed_mps},
                         {"angle_deg", scene.machine.angle_rad * 180.0 / std::numbers::pi},
                         {"spin_radps", scene.machine.spin_radps},
                         {"e", scene.bounce.e},
                         {"mu", scene.bounce.mu},
                         {"dwell_ms", scene.bounce.dwell_s * 1e3}};
  if (!scene.parent.empty()) line["inherits"] = scene.parent;
  if (const auto spring = spring_of_rebound(scene.ball.mass_kg, {scene.bounce.e, scene.bounce.dwell_s})) {
    line["stiffness_npm"] = spring->stiffness_npm;
    line["damping_nspm"] = spring->damping_nspm;
  }
  fmt::print("{}\n", messages::json_text(line));
}

void print_text(const SceneFile& file) {
  if (!file.scene) {
    fmt::print("{:<22} broken\n", file.name);
    return;
  }
  const Scene& scene = *file.scene;
  const double angle_deg = scene.machine.angle_rad * 180.0 / std::numbers::pi;
  const std::string parent = scene.parent.empty() ? "" : " (inherits " + scene.parent + ")";
  fmt::print("{:<22} {:5.2f} m/s  {:6.2f} deg  {:7.1f} rad/s  {}{}\n", scene.name, scene.machine.speed_mps,
             angle_deg, scene.machine.spin_radps, scene.title, parent);
}

}  // namespace

int scenes_command(bool json) {
  const auto files = shipped_scene_files();
  if (!files) {
    fmt::print(stderr, "strobe-sim: {}\n", files.error().message);
    return 2;
  }
  int status = 0;
  for (const SceneFile& file : *files) {
    json ? print_json(file) : print_text(file);
    if (file.scene) continue;
    fmt::print(stderr, "strobe-sim: {}\n", file.scene.error().message);
    status = 1;
  }
  return status;
}

}  // namespace strobe::sim
