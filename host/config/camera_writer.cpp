#include "host/config/camera_writer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <set>
#include <system_error>
#include <vector>

#include "host/config/rig_file.hpp"

namespace strobe::host {
namespace {

const std::set<std::string, std::less<>> kMeasuredKeys{
    "width_px",        "height_px", "px_per_m",     "px_per_m_sd",     "lens_centre_px", "lens_focal_px",
    "lens_distortion", "rectify",   "viewpoint_px", "viewpoint_sd_px", "surface_px",     "surface_sd_px",
    "calibrated",      "board",     "photographs",  "residual_px",     "tilt_deg"};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

template <typename Numbers>
std::string list(const Numbers& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

void add_map(const CameraTable& camera, std::vector<std::string>& lines) {
  if (camera.map) {
    lines.push_back(fmt::format("lens_centre_px = {}", list(camera.map->lens_centre_px)));
    lines.push_back(
        fmt::format("lens_focal_px = {}   # unit of the distortion's argument", camera.map->lens_focal_px));
    lines.push_back(
        fmt::format("lens_distortion = {}   # k1, k2, p1, p2", list(camera.map->lens_distortion)));
    lines.push_back(fmt::format("rectify = {}", list(camera.map->rectify)));
  }
  if (camera.viewpoint_px) {
    lines.push_back(fmt::format("viewpoint_px = {}   # foot of the lens on the plane, its distance",
                                list(*camera.viewpoint_px)));
  }
  if (camera.viewpoint_sd_px) lines.push_back(fmt::format("viewpoint_sd_px = {}", *camera.viewpoint_sd_px));
  if (camera.surface_px) {
    lines.push_back(fmt::format("surface_px = {}", list(*camera.surface_px)));
    lines.push_back(fmt::format("surface_sd_px = {}", camera.surface_sd_px));
  }
}

std::vector<std::string> measured_lines(const CameraTable& camera) {
  std::vector<std::string> lines;
  if (camera.calibrated) lines.push_back("calibrated = " + quoted(*camera.calibrated));
  if (camera.board) lines.push_back("board = " + quoted(*camera.board));
  if (camera.photographs) lines.push_back(fmt::format("photographs = {}", *camera.photographs));
  if (camera.residual_px) lines.push_back(fmt::format("residual_px = {}", *camera.residual_px));
  if (camera.tilt_deg) lines.push_back(fmt::format("tilt_deg = {}", *camera.tilt_deg));
  if (camera.width_px) lines.push_back(fmt::format("width_px = {}", *camera.width_px));
  if (camera.height_px) lines.push_back(fmt::format("height_px = {}", *camera.height_px));
  if (camera.px_per_m) lines.push_back(fmt::format("px_per_m = {}", *camera.px_per_m));
  if (camera.px_per_m_sd) lines.push_back(fmt::format("px_per_m_sd = {}", *camera.px_per_m_sd));
  add_map(camera, lines);
  return lines;
}

/// With their line ends.
std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return lines;
}

std::string stripped(const std::string& line) {
  std::string out = line.substr(0, line.find('#'));
  std::erase_if(out, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
  return out;
}

/// How many brackets a line opens; the measured values that span lines are arrays of numbers.
int opened(const std::string& line) {
  const std::string code = line.substr(0, line.find('#'));
  return static_cast<int>(std::count(code.begin(), code.end(), '[') -
                          std::count(code.begin(), code.end(), ']'));
}

/// The [camera] section's lines without what was measured before.
std::vector<std::string> without_measured(const std::vector<std::string>& section) {
  std::vector<std::string> kept;
  int depth = 0;
  for (const std::string& line : section) {
    if (depth > 0) {
      depth += opened(line);
      continue;
    }
    const std::string code = stripped(line);
    const std::string key = code.substr(0, code.find('='));
    if (code.find('=') != std::string::npos && kMeasuredKeys.contains(key)) {
      const std::string value = code.substr(code.find('=') + 1);
      if (value.starts_with('[')) depth = opened(line);
      continue;
    }
    kept.push_back(line);
  }
  return kept;
}

struct Place {
  std::size_t header = 0;  ///< index of the line [camera]
  std::size_t end = 0;     ///< of the first line after the section
};

Place place_of(const std::vector<std::string>& lines, std::size_t header) {
  std::size_t end = header + 1;
  int depth = 0;
  while (end < lines.size() && !(depth == 0 && stripped(lines[end]).starts_with('['))) {
    const std::string code = stripped(lines[end]);
    if (depth > 0 || code.find("=[") != std::string::npos) depth += opened(lines[end]);
    ++end;
  }
  // Empty lines and comments before the next table belong to that.
  while (end > header + 1 && end < lines.size() && stripped(lines[end - 1]).empty()) --end;
  return {header, end};
}

std::string joined(const std::vector<std::string>& lines, std::size_t from, std::size_t to) {
  std::string text;
  for (std::size_t i = from; i < to; ++i) text += lines[i];
  return text;
}

std::string measured_text(const CameraTable& camera, const std::string& line_end) {
  std::string text;
  for (const std::string& line : measured_lines(camera)) text += line + line_end;
  return text;
}

/// The edit is by lines; whether it came out as meant is read back.
Result<std::string> checked(std::string text, const std::string& file_name, const CameraTable& camera) {
  const auto again = read_rig(text, file_name);
  if (!again) return fail(again.error().message);
  if (measured_lines(again->camera) != measured_lines(camera)) {
    return fail(file_name + ": camera: write the table as [camera] with one key a line");
  }
  return text;
}

}  // namespace

Result<std::string> with_calibration(std::string_view text, const std::string& file_name,
                                     const CameraTable& camera) {
  const auto before = read_rig(text, file_name);
  if (!before) return tl::unexpected(before.error());
  config::TomlReader reader(text, file_name);
  config::TomlTable root = reader.root();
  const std::vector<std::string> lines = split(text);
  const std::string line_end = !lines.empty() && lines.front().ends_with("\r\n") ? "\r\n" : "\n";
  if (!root.has("camera")) {
    std::string whole(text);
    if (!whole.empty() && whole.back() != '\n') whole += line_end;
    return checked(whole + line_end + "[camera]" + line_end + measured_text(camera, line_end), file_name,
                   camera);
  }
  const std::size_t line = root.line_of("camera");
  if (line == 0 || line > lines.size() || stripped(lines[line - 1]) != "[camera]") {
    return fail(
        fmt::format("{}:{}: camera: write the table as [camera] with one key a line", file_name, line));
  }
  const Place place = place_of(lines, line - 1);
  std::vector<std::string> section(lines.begin() + static_cast<std::ptrdiff_t>(place.header),
                                   lines.begin() + static_cast<std::ptrdiff_t>(place.end));
  if (!section.back().ends_with('\n')) section.back() += line_end;
  const std::vector<std::string> kept = without_measured(section);
  return checked(joined(lines, 0, place.header) + joined(kept, 0, kept.size()) +
                     measured_text(camera, line_end) + joined(lines, place.end, lines.size()),
                 file_name, camera);
}

Result<void> replace_file(const std::string& path, std::string_view text) {
  namespace fs = std::filesystem;
  std::error_code wrong;
  const fs::path target = fs::canonical(path, wrong);
  if (wrong) return fail(path + ": " + wrong.message());
  const std::string temporary = fmt::format("{}.{}.new", target.string(), ::getpid());
  std::FILE* file = std::fopen(temporary.c_str(), "wbx");
  if (!file) return fail(temporary + ": " + std::strerror(errno));
  bool good = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  good = std::fflush(file) == 0 && ::fsync(::fileno(file)) == 0 && good;
  good = std::fclose(file) == 0 && good;
  if (good) fs::permissions(temporary, fs::status(target).permissions(), wrong);
  if (good && !wrong) fs::rename(temporary, target, wrong);
  if (good && !wrong) return {};
  std::error_code ignored;
  fs::remove(temporary, ignored);
  return fail(path + ": cannot be written");
}

}  // namespace strobe::host
