#include <fmt/format.h>

#include <string>

#include "sim/loading/tables.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim::tables {

namespace {

using config::Range;
using config::TomlTable;

/// A point at the share r of the view's half diagonal is seen at r + k·r³, which must grow with r: k > -1/3.
constexpr double kMinDistortion = -0.3;
constexpr double kMinTolerance = 1e-9;
constexpr double kMega = 1e6;

void read_lens(TomlTable& table, CameraSettings& c, const ball::Ball& ball) {
  if (const auto distance_m = table.optional_number("distance_m", Range{0.1, 1000.0}))
    c.distance_m = *distance_m;
  c.off_plane_sd_m = table.number_or("off_plane_sd_mm", c.off_plane_sd_m / kMilli, {0.0, 500.0}) * kMilli;
  c.distortion = table.number_or("distortion", c.distortion, {kMinDistortion, 0.5});
  c.swing_rad = table.number_or("swing_deg", 0.0, {-30.0, 30.0}) * kDegree;
  c.tilt_rad = table.number_or("tilt_deg", 0.0, {-30.0, 30.0}) * kDegree;
  if (c.turned() && c.distance_m <= 0.0) table.error_at("distance_m", "is needed with swing_deg or tilt_deg");
  if (c.turned() && c.distortion != 0.0) table.error_at("distortion", "excludes swing_deg and tilt_deg");
  c.pixels = table.choice_or("rendering", "points", {"points", "pixels"}) == "pixels";
  const double nearest_m = kLargestNormal * c.off_plane_sd_m + ball.diameter_m;
  if (c.distance_m > 0.0 && c.distance_m < nearest_m)
    table.error_at(
        "distance_m",
        fmt::format(
            "must be at least {:.3f} m ({:g} off_plane_sd_mm plus a ball's diameter), as balls may fly "
            "up to the lens",
            nearest_m, kLargestNormal));
}

/// Density of the air to which the default spin decay belongs.
constexpr double kUsualDensity_kgpm3 = 1.204;

}  // namespace

AirSettings read_air(TomlTable table, const std::optional<balls::Kind>& kind) {
  AirSettings a;
  if (kind) {
    a.drag_coefficient = kind->air.drag_coefficient;
    a.lift = kind->air.lift_offset > 0.0;
    a.lift_offset = kind->air.lift_offset;
    a.lift_slope = kind->air.lift_slope;
    a.spin_decay_per_m = kind->air.spin_decay_per_m;
  }
  a.temperature_c = table.number_or("temperature_c", a.temperature_c, {-50.0, 80.0});
  a.density_kgpm3 = table.optional_number("density_kgpm3", Range{0.0, 10.0}).value_or(-1.0);
  a.drag_coefficient = table.number_or("drag_coefficient", a.drag_coefficient, {0.0, 2.0});
  a.lift =
      table.choice_or("lift_law", a.lift ? "spin_ratio" : "none", {"spin_ratio", "none"}) == "spin_ratio";
  a.lift_factor = table.number_or("lift_factor", a.lift_factor, {0.0, 3.0});
  const double thinner = a.density_kgpm3 < 0.0 ? 1.0 : a.density_kgpm3 / kUsualDensity_kgpm3;
  a.spin_decay_per_m = table.number_or("spin_decay_per_m", a.spin_decay_per_m * thinner, {0.0, 1.0});
  return a;
}

LampSettings read_lamps(TomlTable table) {
  LampSettings l;
  l.delay_s = table.number_or("delay_us", l.delay_s / kMicro, {0.0, 10000.0}) * kMicro;
  l.jitter_s = table.number_or("jitter_us", l.jitter_s / kMicro, {0.0, 1000.0}) * kMicro;
  l.recharge_s = table.number_or("recharge_us", l.recharge_s / kMicro, {0.0, 1e6}) * kMicro;
  l.flash_s = table.number_or("flash_us", l.flash_s / kMicro, {0.0, 1000.0}) * kMicro;
  return l;
}

SensorSettings read_sensors(TomlTable table) {
  SensorSettings s;
  s.delay_s = table.number_or("delay_us", s.delay_s / kMicro, {0.0, 1000.0}) * kMicro;
  s.jitter_s = table.number_or("jitter_us", s.jitter_s / kMicro, {0.0, 1000.0}) * kMicro;
  s.pulse_s = table.number_or("pulse_us", s.pulse_s / kMicro, {1.0, 10000.0}) * kMicro;
  const std::string crosstalk = table.choice_or("crosstalk", "none", {"none", "a", "b", "both"});
  s.a_sees_b = crosstalk == "a" || crosstalk == "both";
  s.b_sees_a = crosstalk == "b" || crosstalk == "both";
  return s;
}

ShutterSettings read_shutter(TomlTable table) {
  ShutterSettings s;
  s.open_lag_s = table.number_or("open_lag_ms", s.open_lag_s / kMilli, {0.0, 1000.0}) * kMilli;
  s.close_lag_s = table.number_or("close_lag_ms", s.close_lag_s / kMilli, {0.0, 1000.0}) * kMilli;
  s.lag_sd_s = table.number_or("lag_sd_ms", s.lag_sd_s / kMilli, {0.0, 100.0}) * kMilli;
  if (const auto longest_ms = table.optional_number("longest_open_ms", Range{1.0, 60000.0}))
    s.longest_open_s = *longest_ms * kMilli;
  return s;
}

HandSettings read_hand(TomlTable table) {
  HandSettings h;
  if (const auto height_m = table.optional_number("drop_height_m", Range{0.01, 10.0}))
    h.drop_height_m = *height_m;
  h.touchdown_s = table.number_or("touchdown_s", h.touchdown_s, {0.0, 60.0});
  h.spot_sd_m = table.number_or("spot_sd_mm", h.spot_sd_m / kMilli, {0.0, 500.0}) * kMilli;
  return h;
}

CameraSettings read_camera(TomlTable table, const ball::Ball& ball) {
  CameraSettings c;
  c.px_per_m = table.number_or("px_per_m", c.px_per_m, {10.0, 1e6});
  c.roll_rad = table.number_or("roll_deg", c.roll_rad / kDegree, {-45.0, 45.0}) * kDegree;
  c.origin_x_px = table.number_or("origin_x_px", c.origin_x_px, {-1e6, 1e6});
  c.origin_y_px = table.number_or("origin_y_px", c.origin_y_px, {-1e6, 1e6});
  c.half_width_m = table.number_or("half_width_m", c.half_width_m, {0.01, 10.0});
  c.height_m = table.number_or("height_m", c.height_m, {0.01, 10.0});
  c.mirrored = table.boolean_or("mirrored", c.mirrored);
  read_lens(table, c, ball);
  return c;
}

CameraLinkSettings read_camera_link(TomlTable table) {
  CameraLinkSettings l;
  const std::string pixels =
      table.choice_or("pixel_format", "Mono8", {"Mono8", "Mono12", "Mono16", "BayerRG12"});
  if (pixels == "Mono12") l.pixels = CameraPixels::mono12;
  if (pixels == "Mono16") l.pixels = CameraPixels::mono16;
  if (pixels == "BayerRG12") l.pixels = CameraPixels::bayer_rg12;
  l.rate_bps = table.number_or("rate_mbps", l.rate_bps / kMega, {10.0, 1e5}) * kMega;
  l.readout_s = table.number_or("readout_ms", l.readout_s / kMilli, {0.0, 1000.0}) * kMilli;
  l.exposure_step_s = table.number_or("exposure_step_us", l.exposure_step_s / kMicro, {0.1, 1e5}) * kMicro;
  l.loss = table.number_or("loss", l.loss, {0.0, 1.0});
  l.resend_loss = table.number_or("resend_loss", l.resend_loss, {0.0, 1.0});
  l.drop = table.number_or("drop", l.drop, {0.0, 1.0});
  l.clock_offset_s = table.number_or("clock_offset_s", l.clock_offset_s, {0.0, 1e6});
  l.clock_drift_ppm = table.number_or("clock_drift_ppm", l.clock_drift_ppm, {-1000.0, 1000.0});
  const std::string hostile =
      table.choice_or("hostile", "none", {"none", "xml", "sizes", "payload", "endless"});
  using Hostile = CameraLinkSettings::Hostile;
  if (hostile == "xml") l.hostile = Hostile::xml;
  if (hostile == "sizes") l.hostile = Hostile::sizes;
  if (hostile == "payload") l.hostile = Hostile::payload;
  if (hostile == "endless") l.hostile = Hostile::endless;
  return l;
}

TabletSettings read_tablet(TomlTable table) {
  TabletSettings t;
  t.centre_sd_m = table.number_or("centre_sd_mm", t.centre_sd_m / kMilli, {0.0, 50.0}) * kMilli;
  t.equator_sd_rad = table.number_or("equator_sd_deg", t.equator_sd_rad / kDegree, {0.0, 45.0}) * kDegree;
  if (const auto tilt_sd_deg = table.optional_number("equator_tilt_sd_deg", Range{0.001, 45.0}))
    t.equator_tilt_sd_rad = *tilt_sd_deg * kDegree;
  t.digitize_delay_s = table.number_or("digitize_delay_s", t.digitize_delay_s, {0.0, 3600.0});
  t.visible_flattening_m =
      table.number_or("visible_flattening_mm", t.visible_flattening_m / kMilli, {0.0, 20.0}) * kMilli;
  t.calibration_sd = table.optional_number("calibration_sd", Range{0.0, 0.5}).value_or(-1.0);
  return t;
}

ReadoutSettings read_readout(TomlTable table) {
  ReadoutSettings r;
  r.tolerance = table.optional_number("tolerance_percent", Range{1e-6, 100.0}).value_or(0.0) / 100.0;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<reduction::Quantity>(i);
    const std::string_view key = reduction::name(quantity);
    if (table.is_string(key)) {
      if (table.string_or(key, "any") != "any") table.error_at(key, "must be a tolerance or \"any\"");
      r.absolute.emplace_back(quantity, -1.0);
    } else if (const auto tolerance = table.optional_number(key, Range{kMinTolerance, 1e6})) {
      r.absolute.emplace_back(quantity, *tolerance);
    }
  }
  return r;
}

ChipSettings read_chip(TomlTable table) {
  ChipSettings c;
  c.name = table.string_or("name", c.name);
  c.label = table.string_or("label", c.label);
  c.keep_on_release = table.choice_or("on_release", "keep", {"keep", "input"}) == "keep";
  const std::string bias = table.choice_or("bias", "set", {"set", "ignored", "refused"});
  if (bias == "ignored") c.bias = ChipSettings::Bias::ignored;
  if (bias == "refused") c.bias = ChipSettings::Bias::refused;
  const std::string pull = table.choice_or("reset_pull", "none", {"none", "up", "down"});
  if (pull == "up") c.reset_pull = ChipSettings::Pull::up;
  if (pull == "down") c.reset_pull = ChipSettings::Pull::down;
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

}  // namespace strobe::sim::tables
