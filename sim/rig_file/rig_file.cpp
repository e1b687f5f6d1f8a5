#include "sim/rig_file/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <system_error>

#include "common/config/files.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/rig/camera.hpp"

namespace strobe::sim {
namespace {

namespace fs = std::filesystem;

/// A TOML string.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += fmt::format("\\{}", c);
    } else if (byte < 0x20 || byte == 0x7f) {
      result += fmt::format("\\u{:04X}", byte);
    } else {
      result += c;
    }
  }
  return result + "\"";
}

/// As few digits as a person would write, exact to a part in a million.
std::string number(double value) {
  const std::string text = fmt::format("{:.7g}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string line(const std::string& entry, const char* remark) {
  return fmt::format("{:<34} # {}\n", entry, remark);
}

struct Timing {
  double min_period_us = 1500;
  double period_us = 3000;
  double open_ms = 500;
};

/// Between the limits that strobed and lamps set.
Timing timing_of(const Scene& scene) {
  constexpr double kStep_m = 0.051, kUsualSlowest_mps = 10, kUsualFastest_mps = 30, kHundred_us = 100;
  Timing timing;
  timing.min_period_us =
      std::max(timing.min_period_us, kHundred_us * std::ceil(1.05e6 * scene.lamps.recharge_s / kHundred_us));
  const double speed_mps = scene.machine.speed_mps;
  if (speed_mps < kUsualSlowest_mps || speed_mps > kUsualFastest_mps)
    timing.period_us = std::min(10'000.0, kHundred_us * std::round(1e6 * kStep_m / speed_mps / kHundred_us));
  timing.period_us = std::max(timing.period_us, timing.min_period_us);
  const double way_m = scene.machine.drop_height_m > 0.0 ? scene.camera.height_m : scene.camera.half_width_m;
  const double crossing_ms = 2e3 * way_m / speed_mps;
  timing.open_ms = std::clamp(kHundred_us * std::ceil(2.0 * crossing_ms / kHundred_us), 500.0, 1500.0);
  return timing;
}

std::string lines_tables(const Scene& scene, const fs::path& sequencer) {
  if (!sequencer.empty())
    return "# The lines are on a flash sequencer.\n[sequencer]\n" +
           line("port = " + quoted(sequencer.string()), "its serial line") +
           "inputs = [\"sensor_a\", \"sensor_b\", \"gate\"]\n\n";
  return "[chip]\nname = " + quoted(scene.chip.name) +
         "\n\n# Names as the simulated chip has them.\n"
         "[lines]\n"
         "strobe_a = { line = \"STROBE_A\" }\n"
         "strobe_b = { line = \"STROBE_B\" }\n"
         "shutter  = { line = \"SHUTTER\" }\n"
         "trigger  = { line = \"TRIGGER\" }    # pitching machine\n"
         "sensor_a = { line = \"SENSOR_A\" }   # flash sensors\n"
         "sensor_b = { line = \"SENSOR_B\" }\n"
         "gate     = { line = \"GATE\" }       # light gate\n"
         "key      = { line = \"KEY\" }\n"
         "estop    = { line = \"ESTOP\", active_low = true }   # a broken wire stops\n\n";
}

std::string hardware_tables(const Scene& scene, const Timing& timing) {
  return "[lamps]\npulse_us = 50\n" +
         line("delay_us = " + number(1e6 * scene.lamps.delay_s), "from the line's edge to the flash") +
         line("min_period_us = " + number(timing.min_period_us), "the lamps' recharge time, and some more") +
         "max_flashes_per_shot = 400\nmax_on_us = 200\n\n[sensors]\n" +
         line("delay_us = " + number(1e6 * scene.sensors.delay_s), "from the flash to the sensor's edge") +
         "\n[shutter]\n" +
         line("lag_ms = " + number(1e3 * scene.shutter.open_lag_s), "from the line's edge to open") +
         "max_open_s = 2.0\n\n[machine]\n" +
         line("lag_ms = " + number(1e3 * scene.machine.lag_s), "from the trigger to the ball at the plate") +
         "pulse_ms = 20\nmax_on_ms = 100\n\n";
}

std::string plan_table(const Scene& scene, const Timing& timing) {
  const double drop_height_m = scene.machine.drop_height_m;
  return "[plan]\ntrain = \"free\"\n" +
         (drop_height_m > 0.0
              ? line("drop_height_m = " + number(drop_height_m), "which decides the time between flashes")
              : line("period_us = " + number(timing.period_us), "between flashes")) +
         "spacing = \"coded\"\nshutter_open_ms = " + number(timing.open_ms) + "\n" +
         line("impact_at_ms = " + number(0.5 * timing.open_ms), "after the shutter has opened") +
         "\n[tolerance]\nlate_us = 100\n" +
         line("abort_late_us = 1e6", "a simulated lamp flashes when it is told to; a real rig: 1500") +
         "spin_us = 200\nwake_ahead_us = 4000\n"
         "\n[arming]\nexpires_s = 30\n\n[real_time]\npriority = 80\ncpu = -1\n\n";
}

std::string ball_table(const Scene& scene) {
  const ball::Ball& ball = scene.ball;
  const auto fastest = known_fastest_spin_radps(scene);
  std::string kind = scene.kind ? "kind = " + quoted(scene.kind_name) + "\n" : "";
  const bool usual = !scene.kind || scene.kind->marking == balls::Marking::line;
  if (scene.ball_appearance.line != usual) kind += fmt::format("line = {}\n", scene.ball_appearance.line);
  return "[ball]\n" + kind + "diameter_m = " + number(ball.diameter_m) + "\n" +
         line("diameter_sd_m = 0.0002", "as callipers would leave it") + "mass_kg = " + number(ball.mass_kg) +
         "\n" + line(fmt::format("alpha = {}", ball.alpha), "moment of inertia over m R^2") +
         (fastest
              ? line("fastest_spin_radps = " + number(*fastest), "before the bounce: what the machine throws")
              : "") +
         "\n";
}

std::string analysis_table(const Scene& scene, bool network_camera) {
  const double lag_sd_ms = 1e3 * scene.machine.lag_sd_s;
  return "[analysis]\n" +
         line("surface_angle_deg = " + number(scene.surface_angle_rad * 180.0 / std::numbers::pi),
              "inclination of the plate") +
         (network_camera ? "" : line("photograph_timeout_s = 60.0", "the camera renders its photographs")) +
         (lag_sd_ms >= 0.01 ? line("machine_lag_sd_ms = " + number(std::min(lag_sd_ms, 1000.0)),
                                   "of the machine's lag, from shot to shot")
                            : "") +
         "\n";
}

/// Back to what a camera square to the plane would see; `foot`: of its axis, x to the right and y up.
std::string rectify_entry(const CameraSettings& camera, const Eigen::Vector2d& foot, double last_row) {
  const Slant slant(camera.swing_rad, camera.tilt_rad, camera.distance_m * camera.px_per_m);
  Eigen::Matrix3d upright, to_foot, from_foot;
  upright << 1, 0, 0, 0, -1, last_row, 0, 0, 1;
  to_foot << 1, 0, -foot.x(), 0, 1, -foot.y(), 0, 0, 1;
  from_foot << 1, 0, foot.x(), 0, 1, foot.y(), 0, 0, 1;
  const Eigen::Matrix3d whole = from_foot * slant.undoing() * to_foot * upright;
  std::string numbers;
  for (int i = 0; i < 9; ++i)
    numbers += fmt::format("{}{:.12g}", i == 0 ? "" : ", ", whole(i / 3, i % 3) / whole(2, 2));
  return fmt::format("lens_centre_px = [{}, {}]\nlens_focal_px = 1.0\nlens_distortion = [0, 0, 0, 0]\n",
                     number(foot.x()), number(last_row - foot.y())) +
         line("rectify = [" + numbers + "]", "column and row to x and y");
}

/// The lens as the scene bends and places it: columns and rows to the plane of the balls, x right and y up.
std::string lens_entries(const Scene& scene, const SensorSize& sensor) {
  const CameraSettings& camera = scene.camera;
  const double turn = camera.roll_rad + (camera.mirrored ? -1.0 : 1.0) * scene.surface_angle_rad;
  const double half_height_px = 0.5 * camera.height_m * camera.px_per_m;
  const double x = camera.origin_x_px - std::sin(turn) * half_height_px;
  const double y = camera.origin_y_px + std::cos(turn) * half_height_px;
  std::string text;
  if (camera.distortion != 0.0) {
    const double half_diagonal_px = camera.px_per_m * std::hypot(camera.half_width_m, 0.5 * camera.height_m);
    const double last_row = sensor.height - 1.0;
    text +=
        fmt::format("lens_centre_px = [{}, {}]\n", number(x), number(last_row - y)) +
        line("lens_focal_px = " + number(half_diagonal_px), "unit of the distortion's argument") +
        line(fmt::format("lens_distortion = [{}, 0, 0, 0]", number(camera.distortion)), "k1, k2, p1, p2") +
        line(fmt::format("rectify = [1, 0, 0, 0, -1, {}, 0, 0, 1]", number(last_row)),
             "column and row to x and y");
  }
  if (camera.turned()) text += rectify_entry(camera, {x, y}, sensor.height - 1.0);
  if (camera.distance_m > 0.0)
    text += line(fmt::format("viewpoint_px = [{}, {}, {}]", number(x), number(y),
                             number(camera.distance_m * camera.px_per_m)),
                 "the lens: its foot on the plane, and its distance");
  return text;
}

std::string device_entries(const RigFileSettings& settings) {
  if (settings.camera_address.empty()) return "";
  const char* what = settings.camera_kind == "genicam" ? "GigE Vision or USB3 Vision" : "by libgphoto2";
  return line("kind = " + quoted(settings.camera_kind), what) + "serial = " + quoted(settings.camera_serial) +
         "\n" + line("address = " + quoted(settings.camera_address), "where it is looked for") +
         line("exposure = \"line\"", "while the shutter's line is active");
}

std::string camera_table(const Scene& scene, const RigFileSettings& settings) {
  const fs::path& photographs = settings.photographs;
  const SensorSize sensor = sensor_size(scene);
  const double px_per_m = scene.camera.px_per_m;
  return "# As a calibration with a printed board leaves it (strobe calibrate).\n[camera]\n" +
         device_entries(settings) +
         (photographs.empty()
              ? ""
              : line("folder = " + quoted(photographs.string()), "where photographs arrive")) +
         line("px_per_m = " + number(px_per_m), "in the plane in which balls fly") +
         line("px_per_m_sd = " + number(5e-4 * px_per_m), "0.05 %") +
         fmt::format("width_px = {}\nheight_px = {}\n", sensor.width, sensor.height) +
         lens_entries(scene, sensor) + "calibrated = \"2026-11-21\"\n" +
         line("max_age_days = 100000.0", "this camera does not age") + "\n";
}

std::string record_table(const Scene& scene) {
  return "[record]\nball_name = \"simulated\"\nsurface_name = " + quoted("scene " + scene.name) +
         "\ntemperature_c = " + number(scene.air.temperature_c) + "\noperator = \"\"\n\n";
}

std::string report_tables(const Scene& scene) {
  return "# For `strobe report`.\n[laboratory]\nname = \"simulated rig\"\n\n[report]\nitem = " +
         quoted("scene " + scene.name) + "\nremarks = \"Simulated: no ball was thrown.\"\n";
}

/// From `folder` if it leads into it.
fs::path beside(const fs::path& path, const fs::path& folder) {
  if (path.empty()) return path;
  const fs::path whole = fs::absolute(path).lexically_normal();
  const fs::path from_there = whole.lexically_relative(fs::absolute(folder).lexically_normal());
  return from_there.empty() || *from_there.begin() == ".." ? whole : from_there;
}

}  // namespace

std::string rig_file_text(const Scene& scene, const RigFileSettings& settings) {
  const Timing timing = timing_of(scene);
  std::string text =
      fmt::format("# The simulated rig of scene {}, written by strobe-sim run --write-rig.\n\n", scene.name);
  text += line("rig = " + quoted(settings.rig_name), "name in the LCM channels");
  if (!settings.lcm_url.empty()) text += "lcm_url = " + quoted(settings.lcm_url) + "\n";
  text += "\n" + lines_tables(scene, settings.sequencer) + hardware_tables(scene, timing) +
          plan_table(scene, timing);
  if (!settings.key_file.empty())
    text += "[commands]\n" + line("key_file = " + quoted(settings.key_file.string()), "the lab's key") + "\n";
  return text + ball_table(scene) + analysis_table(scene, settings.camera_kind == "genicam") +
         camera_table(scene, settings) + record_table(scene) + report_tables(scene);
}

Result<void> write_rig_file(const fs::path& file, const Scene& scene, RigFileSettings settings) {
  const fs::path folder = fs::absolute(file).parent_path();
  settings.key_file = beside(settings.key_file, folder);
  settings.photographs = beside(settings.photographs, folder);
  const std::string text = rig_file_text(scene, settings);
  std::error_code error;
  if (fs::exists(file, error)) {
    const auto before = config::read_file(file.string());
    if (!before) return tl::unexpected(before.error());
    if (*before == text) return {};
    return fail(file.string() + ": is there already and says something else; remove it or name another file");
  }
  fs::create_directories(folder, error);
  if (!settings.photographs.empty()) fs::create_directories(folder / settings.photographs, error);
  return config::write_file(file, text);
}

}  // namespace strobe::sim
