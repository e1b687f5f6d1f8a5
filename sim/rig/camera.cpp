#include "sim/rig/camera.hpp"

#include <cmath>

namespace strobe::sim {

Camera::Camera(const Scene& scene)
    : settings_(scene.camera),
      turn_rad_(scene.camera.roll_rad +
                (scene.camera.mirrored ? -scene.surface_angle_rad : scene.surface_angle_rad)) {}

reduction::PointPx Camera::project(double x_m, double y_m) const {
  const double x = settings_.mirrored ? -x_m : x_m;
  const double c = std::cos(turn_rad_);
  const double s = std::sin(turn_rad_);
  return {settings_.origin_x_px + settings_.px_per_m * (c * x - s * y_m),
          settings_.origin_y_px + settings_.px_per_m * (s * x + c * y_m)};
}

double Camera::project_angle(double angle_rad) const {
  return (settings_.mirrored ? -angle_rad : angle_rad) + turn_rad_;
}

bool Camera::sees(double x_m, double y_m) const {
  return std::abs(x_m) <= settings_.half_width_m && y_m <= settings_.height_m;
}

}  // namespace strobe::sim
