#include <fmt/format.h>

#include <numbers>
#include <utility>

#include "common/config/toml_reader.hpp"
#include "host/digitize/corrections/corrections.hpp"

namespace strobe::digitize {

namespace {

using config::Range;
using config::TomlTable;

constexpr Range kPixels{-1e6, 1e6};
constexpr Range kLength{0.1, 1e5};
constexpr Range kSd{1e-4, 1e4};

std::optional<ManualPoint> point(TomlTable& table, const std::string& name) {
  std::optional<ManualPoint> found;
  for (const bool in_image : {false, true}) {
    const std::string key = name + (in_image ? "_image_px" : "_px");
    if (!table.has(key)) continue;
    const auto numbers = table.numbers_or(key, {}, kPixels);
    if (numbers.size() != 2) {
      table.error_at(key, "must be two numbers");
      continue;
    }
    if (found) table.error_at(key, "is there twice: " + name + "_px says it already");
    found = ManualPoint{{numbers[0], numbers[1]}, in_image};
  }
  return found;
}

std::optional<double> angle(TomlTable& table, std::string_view key, Range range) {
  auto degrees = table.optional_number(key, range);
  if (degrees) *degrees *= std::numbers::pi / 180.0;
  return degrees;
}

std::optional<reduction::Leg> leg(TomlTable& table) {
  if (!table.has("leg")) return std::nullopt;
  const std::string word = table.choice_or("leg", "", {"incoming", "contact", "rebound"});
  if (word == "incoming") return reduction::Leg::incoming;
  return word == "contact" ? reduction::Leg::contact : reduction::Leg::rebound;
}

/// A number of the frame, NAME_px or NAME_deg, or of the photograph, NAME_image_px or NAME_image_deg.
std::optional<double> of_frame_or_image(TomlTable& table, const std::string& name, const std::string& unit,
                                        Range range, bool& in_image) {
  const std::string frame = name + "_" + unit, image = name + "_image_" + unit;
  auto value = table.optional_number(frame, range);
  if (!table.has(image)) return value;
  if (value) table.error_at(image, "is there twice: " + frame + " says it already");
  in_image = true;
  return table.optional_number(image, range);
}

ManualSurface surface(TomlTable& table) {
  ManualSurface line;
  for (const auto& [name, end] : {std::pair{"left", &line.left}, std::pair{"right", &line.right}}) {
    if (const auto at = point(table, name))
      *end = *at;
    else
      table.error_at("", fmt::format("{0}_px (or {0}_image_px) is missing", name));
  }
  line.sd_px = table.optional_number("sd_px", kSd);
  return line;
}

ManualMeasurement measurement(TomlTable& table) {
  ManualMeasurement measured;
  measured.centre = point(table, "centre");
  measured.centre_sd_px = table.optional_number("centre_sd_px", kSd);
  measured.diameter_px = of_frame_or_image(table, "diameter", "px", kLength, measured.diameter_in_image);
  measured.diameter_sd_px = table.optional_number("diameter_sd_px", kSd);
  measured.equator_rad =
      of_frame_or_image(table, "equator", "deg", {-360.0, 360.0}, measured.equator_in_image);
  if (measured.equator_rad) *measured.equator_rad *= std::numbers::pi / 180.0;
  measured.equator_sd_rad = angle(table, "equator_sd_deg", {1e-3, 90.0});
  measured.no_equator = table.boolean_or("no_equator", false);
  measured.leg = leg(table);
  measured.top = point(table, "top");
  measured.contact_width_px = table.optional_number("contact_width_px", kLength);
  measured.time_s = table.optional_number("time_s", {-1e9, 1e9});
  const auto needs = [&table](bool sd, bool value, const char* sd_key, const char* what) {
    if (sd && !value) table.error_at(sd_key, std::string("is nothing without ") + what);
  };
  needs(measured.centre_sd_px.has_value(), measured.centre.has_value(), "centre_sd_px", "centre_px");
  needs(measured.diameter_sd_px.has_value(), measured.diameter_px.has_value(), "diameter_sd_px",
        "diameter_px");
  needs(measured.equator_sd_rad.has_value(), measured.equator_rad.has_value(), "equator_sd_deg",
        "equator_deg");
  if (measured.no_equator && measured.equator_rad) table.error_at("no_equator", "contradicts equator_deg");
  return measured;
}

bool is_empty(const ManualMeasurement& m) {
  return !m.centre && !m.diameter_px && !m.equator_rad && !m.no_equator && !m.leg && !m.top &&
         !m.contact_width_px && !m.time_s;
}

Correction read(TomlTable& table, Correction::Kind kind, const std::string& file_name) {
  Correction correction;
  correction.kind = kind;
  correction.location = fmt::format("{}:{}", file_name, table.line_of(""));
  if (kind != Correction::Kind::add) {
    if (const auto at = point(table, "at"))
      correction.at = *at;
    else
      table.error_at("", "at_px (or at_image_px) is missing");
  }
  if (kind == Correction::Kind::remove) return correction;
  correction.measured = measurement(table);
  if (kind == Correction::Kind::add && !correction.measured.centre)
    table.error_at("", "centre_px (or centre_image_px) is missing");
  if (kind == Correction::Kind::move && is_empty(correction.measured))
    table.error_at("", "says nothing to change");
  return correction;
}

}  // namespace

Result<std::vector<Correction>> parse_corrections(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  TomlTable root = reader.root();
  std::vector<Correction> corrections;
  const auto read_all = [&](std::string_view key, Correction::Kind kind) {
    for (TomlTable& table : root.tables(key)) corrections.push_back(read(table, kind, file_name));
  };
  read_all("remove", Correction::Kind::remove);
  read_all("move", Correction::Kind::move);
  read_all("add", Correction::Kind::add);
  if (TomlTable table = root.table("surface"); table.present()) {
    Correction& correction = corrections.emplace_back();
    correction.kind = Correction::Kind::surface;
    correction.location = fmt::format("{}:{}", file_name, table.line_of(""));
    correction.surface = surface(table);
  }
  if (auto error = reader.error()) return tl::unexpected(*error);
  if (corrections.empty()) return fail(file_name + ": no [[add]], [[move]], [[remove]] or [surface]");
  return corrections;
}

}  // namespace strobe::digitize
