#include "host/photographs/measure_photograph.hpp"

#include <fmt/format.h>
#include <utility>

#include "common/flight/aerodynamics.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

digitize::SurfaceLine surface_of(const std::array<double, 4>& points, double sd_px) {
  digitize::SurfaceLine line{{{points[0], points[1]}, {points[2], points[3]}}, sd_px};
  if (points[2] < points[0]) std::swap(line.points[0], line.points[1]);
  return line;
}

}  // namespace

Result<digitize::DigitizeSettings> digitize_settings(const RigFile& rig, int width_px, int height_px) {
  const CameraTable& camera = rig.camera;
  if (camera.width_px.value_or(width_px) != width_px || camera.height_px.value_or(height_px) != height_px) {
    return fail(fmt::format("{} x {} pixels, but the camera's calibration is for {} x {}", width_px,
                            height_px, camera.width_px.value_or(width_px),
                            camera.height_px.value_or(height_px)));
  }
  digitize::DigitizeSettings settings;
  settings.ball_diameter_m = rig.ball.diameter_m;
  settings.ball_diameter_sd_m = rig.ball.diameter_sd_m;
  settings.line_drawn = rig.ball.line;
  const double density = flight::air_density_kgpm3(note_number(rig.record, "temperature_c").value_or(20.0));
  settings.drag_per_m = flight::aerodynamics(rig.ball.ball(), density, {}, rig.ball.air_law()).drag_per_m;
  settings.fastest_spin_radps = rig.ball.fastest_spin_radps;
  if (camera.px_per_m) {
    settings.px_per_m = *camera.px_per_m;
    settings.px_per_m_sd = camera.px_per_m_sd;
  } else if (rig.analysis.px_per_m) {
    settings.px_per_m = *rig.analysis.px_per_m;
    settings.px_per_m_sd = rig.analysis.px_per_m_sd;
  }
  settings.map = plane_map(camera, height_px);
  if (camera.surface_px) settings.surface = surface_of(*camera.surface_px, camera.surface_sd_px);
  return settings;
}

Result<digitize::Digitization> measure(const digitize::Photograph& photograph,
                                       const digitize::DigitizeSettings& settings,
                                       const std::vector<digitize::Correction>& corrections,
                                       const CameraTable& camera) {
  auto found = digitize::digitize(photograph, settings);
  if (!found) return fail(photograph.name + ": " + found.error().message);
  if (!corrections.empty()) {
    if (auto applied = digitize::apply_corrections(*found, corrections, settings); !applied)
      return tl::unexpected(applied.error());
  }
  set_calibration(camera, found->frame);
  return found;
}

std::vector<double> flash_times_s(const strobe_msgs::shot_t& shot) {
  const FlashTimes times = flash_times(shot);
  std::vector<double> seconds;
  if (!times.in_order) return seconds;
  for (const ObservedFlash& flash : times.seen)
    seconds.push_back(to_seconds(flash.time - times.seen.front().time));
  return seconds;
}

tl::expected<MeasuredPhotograph, UnreadPhotograph> measure_photograph(const std::filesystem::path& file,
                                                                      const RigFile& rig,
                                                                      const MeasureSettings& wanted) {
  auto photograph = digitize::load_photograph(file);
  if (!photograph) return tl::unexpected(UnreadPhotograph{photograph.error().message, true});
  auto settings = digitize_settings(rig, photograph->width(), photograph->height());
  if (!settings)
    return tl::unexpected(
        UnreadPhotograph{file.filename().string() + ": " + settings.error().message, false});
  photograph->name = file.filename().string();
  settings->effort = wanted.effort;
  if (!wanted.flash_times_s.empty()) settings->flash_times_s = wanted.flash_times_s;
  auto found = measure(*photograph, *settings, wanted.corrections, rig.camera);
  if (!found) return tl::unexpected(UnreadPhotograph{found.error().message, false});
  return MeasuredPhotograph{std::move(*photograph), std::move(*settings), std::move(*found)};
}

}  // namespace strobe::host
