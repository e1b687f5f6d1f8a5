#include "sim/rig/scene.hpp"

#include <cmath>

#include "common/config/toml_reader.hpp"

namespace strobe::sim {

namespace {

using config::Range;
using config::TomlTable;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMilli = 1e-3;
constexpr double kMicro = 1e-6;

ball::Ball read_ball(TomlTable table) {
  ball::Ball ball;
  ball.diameter_m = table.number_or("diameter_m", ball.diameter_m, {0.01, 1.0});
  ball.mass_kg = table.number_or("mass_kg", ball.mass_kg, {0.001, 10.0});
  ball.alpha = table.number_or("alpha", ball.alpha, {0.01, ball::kThinShellAlpha});
  return ball;
}

MachineSettings read_machine(TomlTable table) {
  MachineSettings m;
  m.speed_mps = table.number("speed_mps", {1.0, 60.0});
  m.speed_sd_mps = table.number_or("speed_sd_mps", 0.0, {0.0, 5.0});
  m.angle_rad = table.number("angle_deg", {-85.0, -5.0}) * kDegree;
  m.angle_sd_rad = table.number_or("angle_sd_deg", 0.0, {0.0, 10.0}) * kDegree;
  m.spin_radps = table.number("spin_radps", {-1000.0, 1000.0});
  m.spin_sd_radps = table.number_or("spin_sd_radps", 0.0, {0.0, 200.0});
  m.lag_s = table.number_or("lag_ms", m.lag_s / kMilli, {1.0, 10000.0}) * kMilli;
  m.lag_sd_s = table.number_or("lag_sd_ms", m.lag_sd_s / kMilli, {0.0, 1000.0}) * kMilli;
  m.spot_sd_m = table.number_or("spot_sd_mm", m.spot_sd_m / kMilli, {0.0, 1000.0}) * kMilli;
  return m;
}

BounceSettings read_bounce(TomlTable table, const MachineSettings& machine) {
  BounceSettings b;
  b.e = table.number("e", {0.05, 0.99});
  b.e_speed_mps =
      table.number_or("e_speed_mps", machine.speed_mps * std::abs(std::sin(machine.angle_rad)), {0.0, 60.0});
  b.e_slope_spm = table.number_or("e_slope_s_per_m", b.e_slope_spm, {-0.1, 0.1});
  b.e_sd = table.number_or("e_sd", 0.0, {0.0, 0.3});
  b.mu = table.number("mu", {0.0, 2.0});
  b.mu_sd = table.number_or("mu_sd", 0.0, {0.0, 0.5});
  b.ex = table.number("ex", {-1.0, 1.0});
  b.ex_sd = table.number_or("ex_sd", 0.0, {0.0, 1.0});
  b.offset_m = table.number("offset_mm", {0.0, 20.0}) * kMilli;
  b.offset_sd_m = table.number_or("offset_sd_mm", 0.0, {0.0, 20.0}) * kMilli;
  b.offset_grip_correlation = table.number_or("offset_grip_correlation", 0.0, {-1.0, 1.0});
  b.dwell_s = table.number("dwell_ms", {0.1, 50.0}) * kMilli;
  b.dwell_sd_s = table.number_or("dwell_sd_ms", 0.0, {0.0, 10.0}) * kMilli;
  b.top_drop_ratio = table.number_or("top_drop_ratio", b.top_drop_ratio, {0.5, 2.0});
  return b;
}

AirSettings read_air(TomlTable table) {
  AirSettings a;
  a.temperature_c = table.number_or("temperature_c", a.temperature_c, {-50.0, 80.0});
  a.density_kgpm3 = table.optional_number("density_kgpm3", Range{0.0, 10.0}).value_or(-1.0);
  a.drag_coefficient = table.number_or("drag_coefficient", a.drag_coefficient, {0.0, 2.0});
  a.lift = table.choice_or("lift_law", "spin_ratio", {"spin_ratio", "none"}) == "spin_ratio";
  return a;
}

LampSettings read_lamps(TomlTable table) {
  LampSettings l;
  l.delay_s = table.number_or("delay_us", l.delay_s / kMicro, {0.0, 10000.0}) * kMicro;
  l.jitter_s = table.number_or("jitter_us", l.jitter_s / kMicro, {0.0, 1000.0}) * kMicro;
  l.recharge_s = table.number_or("recharge_us", l.recharge_s / kMicro, {0.0, 1e6}) * kMicro;
  return l;
}

SensorSettings read_sensors(TomlTable table) {
  SensorSettings s;
  s.delay_s = table.number_or("delay_us", s.delay_s / kMicro, {0.0, 1000.0}) * kMicro;
  s.jitter_s = table.number_or("jitter_us", s.jitter_s / kMicro, {0.0, 1000.0}) * kMicro;
  s.pulse_s = table.number_or("pulse_us", s.pulse_s / kMicro, {1.0, 10000.0}) * kMicro;
  return s;
}

ShutterSettings read_shutter(TomlTable table) {
  ShutterSettings s;
  s.open_lag_s = table.number_or("open_lag_ms", s.open_lag_s / kMilli, {0.0, 1000.0}) * kMilli;
  s.close_lag_s = table.number_or("close_lag_ms", s.close_lag_s / kMilli, {0.0, 1000.0}) * kMilli;
  s.lag_sd_s = table.number_or("lag_sd_ms", s.lag_sd_s / kMilli, {0.0, 100.0}) * kMilli;
  return s;
}

CameraSettings read_camera(TomlTable table) {
  CameraSettings c;
  c.px_per_m = table.number_or("px_per_m", c.px_per_m, {10.0, 1e6});
  c.roll_rad = table.number_or("roll_deg", c.roll_rad / kDegree, {-45.0, 45.0}) * kDegree;
  c.origin_x_px = table.number_or("origin_x_px", c.origin_x_px, {-1e6, 1e6});
  c.origin_y_px = table.number_or("origin_y_px", c.origin_y_px, {-1e6, 1e6});
  c.half_width_m = table.number_or("half_width_m", c.half_width_m, {0.01, 10.0});
  c.height_m = table.number_or("height_m", c.height_m, {0.01, 10.0});
  c.mirrored = table.boolean_or("mirrored", c.mirrored);
  return c;
}

TabletSettings read_tablet(TomlTable table) {
  TabletSettings t;
  t.centre_sd_m = table.number_or("centre_sd_mm", t.centre_sd_m / kMilli, {0.0, 50.0}) * kMilli;
  t.equator_sd_rad = table.number_or("equator_sd_deg", t.equator_sd_rad / kDegree, {0.0, 45.0}) * kDegree;
  t.digitize_delay_s = table.number_or("digitize_delay_s", t.digitize_delay_s, {0.0, 3600.0});
  t.visible_flattening_m =
      table.number_or("visible_flattening_mm", t.visible_flattening_m / kMilli, {0.0, 20.0}) * kMilli;
  t.calibration_sd = table.optional_number("calibration_sd", Range{0.0, 0.5}).value_or(-1.0);
  return t;
}

ChipSettings read_chip(TomlTable table) {
  ChipSettings c;
  c.name = table.string_or("name", c.name);
  c.label = table.string_or("label", c.label);
  c.keep_on_release = table.choice_or("on_release", "keep", {"keep", "input"}) == "keep";
  c.key_level = static_cast<int>(table.integer_or("key_level", c.key_level, {0, 1}));
  c.estop_level = static_cast<int>(table.integer_or("estop_level", c.estop_level, {0, 1}));
  return c;
}

OperatorAction read_action(TomlTable& table) {
  OperatorAction action;
  action.at_s = table.number("at_s", {0.0, 1e6});
  action.line = *rig_line(table.choice_or("line", "KEY", {"KEY", "ESTOP", "GATE", "SENSOR_A", "SENSOR_B"}));
  if (!table.has("line")) table.error_at("line", "is missing");
  action.level = static_cast<int>(table.integer("level", {0, 1}));
  return action;
}

std::string stem(const std::string& file_name) {
  const std::size_t slash = file_name.find_last_of('/');
  std::string base = slash == std::string::npos ? file_name : file_name.substr(slash + 1);
  if (base.size() > 5 && base.ends_with(".toml")) base.resize(base.size() - 5);
  return base;
}

}  // namespace

Result<Scene> parse_scene(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  TomlTable root = reader.root();
  Scene scene;
  scene.name = stem(file_name);
  scene.title = root.string_or("title", scene.name);
  scene.surface_angle_rad = root.number_or("surface_angle_deg", 0.0, {-89.0, 89.0}) * kDegree;
  scene.ball = read_ball(root.table("ball"));
  scene.machine = read_machine(root.table("machine"));
  scene.bounce = read_bounce(root.table("bounce"), scene.machine);
  scene.air = read_air(root.table("air"));
  scene.lamps = read_lamps(root.table("lamps"));
  scene.sensors = read_sensors(root.table("sensors"));
  scene.shutter = read_shutter(root.table("shutter"));
  scene.gate.distance_m = root.table("gate").number_or("distance_m", scene.gate.distance_m, {0.1, 20.0});
  scene.camera = read_camera(root.table("camera"));
  scene.tablet = read_tablet(root.table("tablet"));
  scene.chip = read_chip(root.table("chip"));
  for (TomlTable& table : root.tables("operator")) scene.operator_actions.push_back(read_action(table));
  scene.faults = read_faults(root);
  if (auto bad = reader.error()) return tl::unexpected(*bad);
  return scene;
}

}  // namespace strobe::sim
