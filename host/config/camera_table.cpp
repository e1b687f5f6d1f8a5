#include "host/config/camera_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glib.h>

#include <Eigen/Dense>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

namespace strobe::host {
namespace {

using config::Range;
using config::TomlTable;

constexpr Range kPlace{-1e9, 1e9};
constexpr Range kFactor{-1e12, 1e12};

template <std::size_t N>
std::optional<std::array<double, N>> optional_array(TomlTable& table, std::string_view key, Range range) {
  if (!table.has(key)) return std::nullopt;
  const std::vector<double> values = table.numbers_or(key, {}, range);
  if (values.size() != N) {
    table.error_at(key, fmt::format("must be {} numbers", N));
    return std::nullopt;
  }
  std::array<double, N> result{};
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

template <std::size_t N>
std::array<double, N> required_array(TomlTable& table, std::string_view key, Range range) {
  if (!table.has(key)) table.error_at("rectify", fmt::format("needs {} too", key));
  return optional_array<N>(table, key, range).value_or(std::array<double, N>{});
}

std::optional<int> optional_count(TomlTable& table, std::string_view key, Range range) {
  if (!table.has(key)) return std::nullopt;
  return static_cast<int>(table.integer_or(key, 1, range));
}

std::optional<std::string> optional_text(TomlTable& table, std::string_view key) {
  if (!table.has(key)) return std::nullopt;
  return table.string(key);
}

std::optional<CameraMap> read_map(TomlTable& table) {
  const auto rectify = optional_array<9>(table, "rectify", kFactor);
  for (const char* key : {"lens_centre_px", "lens_focal_px", "lens_distortion"}) {
    if (table.has(key) && !table.has("rectify")) table.error_at(key, "needs rectify too");
  }
  if (!rectify) return std::nullopt;
  CameraMap map;
  map.rectify = *rectify;
  const double determinant = Eigen::Map<const Eigen::Matrix3d>(map.rectify.data()).determinant();
  if (!(std::abs(determinant) > 1e-12)) table.error_at("rectify", "must not be singular");
  map.lens_centre_px = required_array<2>(table, "lens_centre_px", kPlace);
  map.lens_focal_px = table.number("lens_focal_px", {1.0, 1e9});
  map.lens_distortion = required_array<4>(table, "lens_distortion", kFactor);
  for (const char* key : {"width_px", "height_px", "px_per_m"}) {
    if (!table.has(key)) table.error_at("rectify", fmt::format("needs {} too", key));
  }
  return map;
}

constexpr std::size_t kPerMapError = 13;
constexpr std::size_t kMaxMapErrors = 64;

void read_map_errors(TomlTable& table, CameraTable& camera) {
  if (!table.has("map_errors")) return;
  if (!camera.map) return table.error_at("map_errors", "needs rectify too");
  const std::vector<double> values = table.numbers_or("map_errors", {}, kFactor);
  if (values.size() % kPerMapError != 0 || values.size() > kPerMapError * kMaxMapErrors)
    return table.error_at("map_errors", "must be 13 numbers for each error, of at most 64");
  for (std::size_t i = 0; i < values.size(); i += kPerMapError) {
    CameraMapError& error = camera.map_errors.emplace_back();
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(i);
    std::copy_n(first, error.rectify.size(), error.rectify.begin());
    std::copy_n(first + static_cast<std::ptrdiff_t>(error.rectify.size()), error.lens_distortion.size(),
                error.lens_distortion.begin());
  }
}

std::string map_errors_line(const std::vector<CameraMapError>& errors) {
  if (errors.empty()) return "";
  std::vector<std::string> rows;
  for (const CameraMapError& error : errors)
    rows.push_back(
        fmt::format("  {}, {}", fmt::join(error.rectify, ", "), fmt::join(error.lens_distortion, ", ")));
  return fmt::format(
      "# what one sd of each of the map's errors adds to rectify and lens_distortion\nmap_errors = "
      "[\n{}\n]\n",
      fmt::join(rows, ",\n"));
}

std::optional<std::chrono::sys_days> parse_date(const std::string& text) {
  int year = 0, month = 0, day = 0, used = 0;
  if (text.size() != 10 || std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &year, &month, &day, &used) != 3 ||
      used != 10) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

void read_surface(TomlTable& table, CameraTable& camera) {
  camera.surface_px = optional_array<4>(table, "surface_px", kPlace);
  camera.surface_sd_px = table.number_or("surface_sd_px", camera.surface_sd_px, {1e-4, 1000.0});
  if (!camera.surface_px) return;
  const auto& s = *camera.surface_px;
  if (std::hypot(s[2] - s[0], s[3] - s[1]) < 1.0) {
    table.error_at("surface_px", "must be two points a pixel or more apart");
  }
}

void read_viewpoint(TomlTable& table, CameraTable& camera) {
  camera.viewpoint_px = optional_array<3>(table, "viewpoint_px", kPlace);
  camera.viewpoint_sd_px = table.optional_number("viewpoint_sd_px", {0.0, 1e9});
  if (camera.viewpoint_px && !((*camera.viewpoint_px)[2] >= 1.0)) {
    table.error_at("viewpoint_px", "its third number, the distance, must be at least 1 px");
  }
}

void read_calibration(TomlTable& table, CameraTable& camera) {
  camera.width_px = optional_count(table, "width_px", {16, 100'000});
  camera.height_px = optional_count(table, "height_px", {16, 100'000});
  camera.px_per_m = table.optional_number("px_per_m", {1.0, 1e7});
  camera.px_per_m_sd = table.optional_number("px_per_m_sd", {0.0, 1e6});
  if (camera.px_per_m_sd && !camera.px_per_m) table.error_at("px_per_m_sd", "needs px_per_m too");
  camera.map = read_map(table);
  read_map_errors(table, camera);
  read_viewpoint(table, camera);
  read_surface(table, camera);
  camera.calibrated = optional_text(table, "calibrated");
  if (camera.calibrated && !parse_date(*camera.calibrated)) {
    table.error_at("calibrated", "must be a date, such as 2026-11-21");
  }
  camera.board = optional_text(table, "board");
  camera.photographs = optional_count(table, "photographs", {1, 1000});
  camera.left_out = optional_text(table, "left_out");
  camera.residual_px = table.optional_number("residual_px", {0.0, 1e6});
  camera.tilt_deg = table.optional_number("tilt_deg", {0.0, 90.0});
}

std::map<std::string, std::string> read_settings(TomlTable table) {
  std::map<std::string, std::string> settings;
  for (const std::string& key : table.keys()) {
    if (table.is_string(key)) {
      settings[key] = table.string(key);
    } else if (table.is_boolean(key)) {
      settings[key] = table.boolean_or(key, false) ? "true" : "false";
    } else if (table.is_integer(key)) {
      settings[key] = fmt::format("{}", table.integer(key));
    } else {
      settings[key] = fmt::format("{}", table.number(key));
    }
  }
  return settings;
}

CameraConnection read_connection(TomlTable& table) {
  CameraConnection connection;
  const std::string kind = table.choice_or("kind", "folder", {"folder", "genicam", "gphoto2"});
  connection.kind = kind == "genicam"   ? CameraKind::genicam
                    : kind == "gphoto2" ? CameraKind::gphoto2
                                        : CameraKind::folder;
  for (const char* key : {"serial", "address", "exposure", "delete_from_camera", "set"}) {
    if (connection.kind == CameraKind::folder && table.has(key))
      table.error_at(key, "needs kind = \"genicam\" or \"gphoto2\"");
  }
  connection.serial = table.string_or("serial", "");
  connection.address = table.string_or("address", "");
  connection.exposure_by_line = table.choice_or("exposure", "line", {"line", "timed"}) == "line";
  connection.delete_from_camera = table.boolean_or("delete_from_camera", false);
  connection.set = read_settings(table.table("set"));
  return connection;
}

template <typename Value>
std::string line(std::string_view key, const std::optional<Value>& value, std::string_view remark = "") {
  return value ? fmt::format("{} = {}{}\n", key, *value, remark) : "";
}

/// A file's name may hold any bytes.
std::optional<std::string> quoted(const std::optional<std::string>& text) {
  if (!text) return std::nullopt;
  const std::unique_ptr<char, decltype(&g_free)> valid(
      g_utf8_make_valid(text->data(), static_cast<gssize>(text->size())), g_free);
  std::string escaped;
  for (const char c : std::string_view(valid.get())) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += static_cast<unsigned char>(c) < ' ' || c == 0x7f ? ' ' : c;
  }
  return "\"" + escaped + "\"";
}

}  // namespace

std::string_view name(CameraKind kind) {
  switch (kind) {
    case CameraKind::folder:
      return "folder";
    case CameraKind::genicam:
      return "genicam";
    case CameraKind::gphoto2:
      return "gphoto2";
  }
  return "";
}

CameraTable read_camera(TomlTable table) {
  CameraTable camera;
  camera.connection = read_connection(table);
  camera.folder = optional_text(table, "folder");
  if (camera.folder && camera.folder->empty()) table.error_at("folder", "must not be empty");
  camera.max_age_days = table.number_or("max_age_days", camera.max_age_days, {0.01, 100'000.0});
  camera.calibration = optional_text(table, "calibration");
  const auto& name = camera.calibration;
  if (name && (name->find('/') != std::string::npos || !name->ends_with("camera.toml")))
    table.error_at("calibration", "must be the name of a file beside this one, ending in camera.toml");
  read_calibration(table, camera);
  return camera;
}

Result<CameraTable> with_calibration(const CameraTable& camera, std::string_view text,
                                     const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  CameraTable calibrated;
  calibrated.connection = camera.connection;
  calibrated.folder = camera.folder;
  calibrated.max_age_days = camera.max_age_days;
  calibrated.calibration = camera.calibration;
  TomlTable root = reader.root();
  read_calibration(root, calibrated);
  if (const auto bad = reader.error()) return fail(bad->message);
  return calibrated;
}

std::string calibration_text(const CameraTable& camera) {
  std::string text = "# Written by strobe calibrate; its next run replaces this file.\n";
  text += line("calibrated", quoted(camera.calibrated)) + line("board", quoted(camera.board)) +
          line("photographs", camera.photographs) + line("left_out", quoted(camera.left_out)) +
          line("residual_px", camera.residual_px) + line("tilt_deg", camera.tilt_deg) +
          line("width_px", camera.width_px) + line("height_px", camera.height_px) +
          line("px_per_m", camera.px_per_m) + line("px_per_m_sd", camera.px_per_m_sd);
  if (const auto& map = camera.map) {
    text +=
        line("lens_centre_px", std::optional(map->lens_centre_px)) +
        line("lens_focal_px", std::optional(map->lens_focal_px), "   # unit of the distortion's argument") +
        line("lens_distortion", std::optional(map->lens_distortion), "   # k1, k2, p1, p2") +
        line("rectify", std::optional(map->rectify)) + map_errors_line(camera.map_errors);
  }
  text += line("viewpoint_px", camera.viewpoint_px, "   # foot of the lens on the plane, its distance") +
          line("viewpoint_sd_px", camera.viewpoint_sd_px) + line("surface_px", camera.surface_px);
  return camera.surface_px ? text + line("surface_sd_px", std::optional(camera.surface_sd_px)) : text;
}

std::optional<std::int64_t> days_since(const std::string& date, WallTime now) {
  const auto day = parse_date(date);
  if (!day) return std::nullopt;
  return (std::chrono::floor<std::chrono::days>(now) - *day).count();
}

std::string date_of(WallTime now) {
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(now));
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

std::optional<std::string> calibration_warning(const CameraTable& camera, WallTime now) {
  if (!camera.px_per_m_sd) return std::nullopt;  // a first guess, refined on each photograph
  if (!camera.calibrated) return "the camera's calibration has no date";
  const auto days = days_since(*camera.calibrated, now);
  if (!days || static_cast<double>(*days) <= camera.max_age_days) return std::nullopt;
  return fmt::format(
      "the camera's calibration is of {}, {} days ago (camera.max_age_days is {}): calibrate again",
      *camera.calibrated, *days, camera.max_age_days);
}

}  // namespace strobe::host
