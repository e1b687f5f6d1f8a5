#include "host/photographs/digitize_settings.hpp"

#include <fmt/format.h>

#include <utility>

#include "host/assembly/camera_map.hpp"

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

}  // namespace strobe::host
