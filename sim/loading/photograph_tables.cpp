#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "sim/loading/tables.hpp"

namespace strobe::sim::tables {

namespace {

using config::Range;
using config::TomlTable;

/// `key` in units of `unit`.
std::optional<double> scaled(TomlTable& table, std::string_view key, Range range, double unit) {
  const auto number = table.optional_number(key, range);
  return number ? std::optional(*number * unit) : std::nullopt;
}

int side(TomlTable& table, std::string_view key) {
  return table.has(key) ? static_cast<int>(table.integer(key, {16, 20000})) : 0;
}

int bits(TomlTable& table, int fallback) {
  const auto number = static_cast<int>(table.integer_or("bits", fallback, {8, 16}));
  if (number != 8 && number != 12 && number != 14 && number != 16)
    table.error_at("bits", "must be 8, 12, 14 or 16");
  return number;
}

PhotographFormat format(TomlTable& table) {
  const std::string name = table.choice_or("format", "tiff", {"tiff", "png", "dng", "mosaic"});
  return name == "png"      ? PhotographFormat::png
         : name == "dng"    ? PhotographFormat::dng
         : name == "mosaic" ? PhotographFormat::mosaic
                            : PhotographFormat::tiff;
}

BallSurface surface_of(balls::Marking marking) {
  switch (marking) {
    case balls::Marking::line:
    case balls::Marking::seam:
      break;
    case balls::Marking::dimples:
      return BallSurface::dimples;
    case balls::Marking::stitches:
      return BallSurface::stitches;
    case balls::Marking::dots:
      return BallSurface::dots;
    case balls::Marking::panels:
      return BallSurface::panels;
    case balls::Marking::holes:
      return BallSurface::holes;
    case balls::Marking::plain:
      return BallSurface::plain;
  }
  return BallSurface::felt;
}

BallSurface surface(TomlTable& table, BallSurface fallback) {
  // In the order of BallSurface.
  static const std::vector<std::string_view> names{"felt",   "plain",    "dimples", "stitches", "band",
                                                   "panels", "channels", "holes",   "dots"};
  const auto name = table.choice_or("surface", names[static_cast<std::size_t>(fallback)], names);
  return static_cast<BallSurface>(std::ranges::find(names, name) - names.begin());
}

}  // namespace

PhotographSettings read_photograph(TomlTable table) {
  PhotographSettings p;
  p.width_px = side(table, "width_px");
  p.height_px = side(table, "height_px");
  p.format = format(table);
  p.bits = bits(table, is_mosaic(p.format) ? kMosaicBits : p.bits);
  if (is_mosaic(p.format) && p.bits == 8) table.error_at("bits", "must be 12, 14 or 16 of a mosaic");
  p.exposure = table.number_or("exposure", p.exposure, {0.01, 100.0});
  p.gamma = table.number_or("gamma", p.gamma, {0.3, 3.0});
  p.full_well_e = table.number_or("full_well_e", p.full_well_e, {100.0, 1e6});
  p.read_noise_e = table.number_or("read_noise_e", p.read_noise_e, {0.0, 1000.0});
  p.black_level = table.number_or("black_level", p.black_level, {0.0, 0.2});
  p.blur_px = table.optional_number("blur_px", {0.0, 10.0});
  p.defocus_px = table.number_or("defocus_px", p.defocus_px, {0.0, 10.0});
  p.vignetting = table.optional_number("vignetting", {0.0, 0.9});
  p.lamp_a_power = table.number_or("lamp_a_power", p.lamp_a_power, {0.0, 10.0});
  p.lamp_b_power = table.number_or("lamp_b_power", p.lamp_b_power, {0.0, 10.0});
  p.flash_power_sd = table.number_or("flash_power_sd", p.flash_power_sd, {0.0, 0.3});
  p.second_flash = table.number_or("second_flash", p.second_flash, {0.0, 0.9});
  p.second_flash_s = table.number_or("second_flash_us", p.second_flash_s / kMicro, {0.0, 400.0}) * kMicro;
  p.ambient = table.number_or("ambient", p.ambient, {0.0, 0.9});
  p.steady = table.choice_or("setup", "drawn", {"drawn", "steady"}) == "steady";
  return p;
}

BallAppearanceSettings read_ball_appearance(TomlTable table, const std::optional<balls::Kind>& kind) {
  BallAppearanceSettings b;
  const balls::Marking marking = kind ? kind->marking : balls::Marking::line;
  b.surface = surface(table, surface_of(marking));
  b.line = table.boolean_or("line", marking == balls::Marking::line);
  b.line_width_m = scaled(table, "line_width_mm", {0.3, 15.0}, kMilli);
  b.line_contrast = table.optional_number("line_contrast", {0.0, 1.0});
  b.line_tilt_rad = scaled(table, "line_tilt_deg", {-75.0, 75.0}, kDegree);
  b.line_offset = table.number_or("line_offset", 0.0, {-0.1, 0.1});
  b.grain = table.optional_number("grain", {0.0, 0.5});
  b.albedo = table.optional_number("albedo", {0.02, 2.0});
  b.shine = table.optional_number("shine", {0.0, 2.0});
  b.seam_contrast = table.optional_number("seam_contrast", {-10.0, 1.0});
  b.logo_contrast = table.optional_number("logo_contrast", {-10.0, 1.0});
  b.fuzz_px = table.optional_number("fuzz_px", {0.0, 5.0});
  b.lamp_height_m = table.optional_number("lamp_height_m", {-5.0, 5.0});
  b.lamp_aside_m = table.optional_number("lamp_aside_m", {0.05, 10.0});
  b.lamp_forward_m = table.optional_number("lamp_forward_m", {0.1, 20.0});
  return b;
}

BackgroundSettings read_background(TomlTable table) {
  BackgroundSettings b;
  b.wall = table.optional_number("wall", {0.0, 2.0});
  b.wall_distance_m = table.number_or("wall_distance_m", b.wall_distance_m, {0.1, 20.0});
  b.plate = table.boolean_or("plate", b.plate);
  b.plate_brightness = table.optional_number("plate_brightness", {0.0, 20.0});
  b.plate_thickness_m = scaled(table, "plate_thickness_mm", {1.0, 200.0}, kMilli);
  b.plate_depth_m = table.number_or("plate_depth_mm", b.plate_depth_m / kMilli, {0.0, 2000.0}) * kMilli;
  b.plate_half_length_m = table.optional_number("plate_half_length_m", {0.05, 5.0});
  b.clutter = table.number_or("clutter", b.clutter, {0.0, 3.0});
  b.blobs = static_cast<int>(table.integer_or("blobs", b.blobs, {0, 20}));
  if (table.has("flashes")) b.flashes = static_cast<int>(table.integer("flashes", {1, 100000}));
  return b;
}

}  // namespace strobe::sim::tables
