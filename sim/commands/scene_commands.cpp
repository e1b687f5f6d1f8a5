
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "sim/commands/commands.hpp"
#include "sim/fit/fit.hpp"
#include "sim/loading/load_scene.hpp"
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

void print_json(const FittedScene& fitted, const thesis::Condition& condition) {
  nlohmann::json missed = nlohmann::json::object();
  for (const MissedSpread& miss : fitted.missed)
    missed[std::string(reduction::name(miss.quantity))] = {{"published_sd", miss.published_sd},
                                                           {"here", miss.expected_sd}};
  const nlohmann::json line = {{"scene", condition.name()},
                               {"slides", fitted.slides},
                               {"left_vx_lo_mps", fitted.left_vx_mps},
                               {"left_omega_lo_radps", fitted.left_omega_radps},
                               {"left_vx_lo_in_sd", fitted.left_vx_mps / condition.vx_lo_mps.sd},
                               {"left_omega_lo_in_sd", fitted.left_omega_radps / condition.omega_lo_radps.sd},
                               {"missed_spreads", missed}};
  fmt::print("{}\n", messages::json_text(line));
}

void print_text(const FittedScene& fitted, const thesis::Condition& condition) {
  fmt::print("{:<8} left of the lift-off: vx {:6.3f} m/s ({:5.2f} sd), spin {:6.2f} rad/s ({:5.2f} sd)\n",
             condition.name(), fitted.left_vx_mps, fitted.left_vx_mps / condition.vx_lo_mps.sd,
             fitted.left_omega_radps, fitted.left_omega_radps / condition.omega_lo_radps.sd);
  for (const MissedSpread& miss : fitted.missed)
    fmt::print("{:<8} {}: published sd {:.3g}, here {:.3g}\n", "", reduction::name(miss.quantity),
               miss.published_sd, miss.expected_sd);
}

}  // namespace

int scenes_command(bool json) {
  const auto files = shipped_scene_files();
  if (!files) return report_error(files.error().message, 2);
  int status = 0;
  for (const SceneFile& file : *files) {
    json ? print_json(file) : print_text(file);
    if (file.scene) continue;
    status = report_error(file.scene.error().message, 1);
  }
  return status;
}

int fit_command(const std::string& tables, const std::string& folder, bool json) {
  const auto data = thesis::load(tables, thesis::Version::corrected);
  if (!data) return report_error(data.error().message, 2);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const thesis::Condition& condition : data->conditions) {
    const auto fitted = fit_scene(condition);
    if (!fitted) return report_error(fitted.error().message, 1);
    const std::filesystem::path path = std::filesystem::path(folder) / (condition.name() + ".toml");
    if (const auto written = config::write_file(path, to_toml(*fitted, condition)); !written)
      return report_error(written.error().message, 2);
    json ? print_json(*fitted, condition) : print_text(*fitted, condition);
  }
  return 0;
}

}  // namespace strobe::sim
