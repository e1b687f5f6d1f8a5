#include "sim/photograph/optics.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::sim {

namespace {

constexpr double kMarginAside_m = 0.045;
constexpr double kMarginAbove_m = 0.035;
constexpr int kNewtonSteps = 6;

int side(int asked, double holds_view) {
  if (asked > 0) return asked;
  return static_cast<int>(std::clamp(std::round(holds_view), 16.0, 20000.0));
}

/// g of g·(1 + beta·g²) = 1: the share of the seen distance from the axis that is the true one.
double straighten(double beta) {
  // Beyond this the curve has turned back.
  if (beta < -4.0 / 27.0) return 1.5;
  double g = 1.0;
  for (int i = 0; i < kNewtonSteps; ++i) g -= (g + beta * g * g * g - 1.0) / (1.0 + 3.0 * beta * g * g);
  return g;
}

}  // namespace

SensorSize sensor_size(const Scene& scene) {
  const CameraSettings& c = scene.camera;
  return {
      side(scene.photograph.width_px, c.origin_x_px + c.px_per_m * (c.half_width_m + kMarginAside_m)),
      side(scene.photograph.height_px, c.origin_y_px + c.px_per_m * (c.height_m + kMarginAbove_m)),
  };
}

Optics::Optics(const Scene& scene)
    : sensor_(sensor_size(scene)),
      px_per_m_(scene.camera.px_per_m),
      origin_x_px_(scene.camera.origin_x_px),
      origin_y_px_(scene.camera.origin_y_px),
      half_height_m_(0.5 * scene.camera.height_m),
      distance_m_(scene.camera.distance_m),
      mirrored_(scene.camera.mirrored) {
  const double turn =
      scene.camera.roll_rad + (mirrored_ ? -scene.surface_angle_rad : scene.surface_angle_rad);
  turn_cos_ = std::cos(turn);
  turn_sin_ = std::sin(turn);
  const double w = scene.camera.half_width_m;
  bend_pm2_ = scene.camera.distortion / (w * w + half_height_m_ * half_height_m_);
  if (!scene.camera.turned()) return;
  const Vec2 foot = image_of({0.0, 0.0, 0.0});
  foot_px_ = {foot.x, sensor_.height - 1.0 - foot.y};
  slant_ = Slant(scene.camera.swing_rad, scene.camera.tilt_rad, px_per_m_ * distance_m_);
}

Vec2 Optics::plane_at(double column, double row) const {
  if (!slant_.is_none()) {
    const Eigen::Vector2d square =
        foot_px_ + slant_.undo(Eigen::Vector2d(column, sensor_.height - 1.0 - row) - foot_px_);
    column = square.x();
    row = sensor_.height - 1.0 - square.y();
  }
  const double u = (column - origin_x_px_) / px_per_m_;
  const double v = (sensor_.height - 1.0 - row - origin_y_px_) / px_per_m_;
  const Vec2 seen{turn_cos_ * u + turn_sin_ * v, turn_cos_ * v - turn_sin_ * u - half_height_m_};
  if (bend_pm2_ == 0.0) return seen;
  const double g = straighten(bend_pm2_ * (seen.x * seen.x + seen.y * seen.y));
  return {g * seen.x, g * seen.y};
}

Vec2 Optics::image_of(const Vec3& p) const {
  const double nearer = perspective() ? distance_m_ / (distance_m_ - p.z) : 1.0;
  double x = nearer * p.x;
  double y = nearer * p.y;
  const double stretch = 1.0 + bend_pm2_ * (x * x + y * y);
  x *= stretch;
  y = stretch * y + half_height_m_;
  Eigen::Vector2d seen(origin_x_px_ + px_per_m_ * (turn_cos_ * x - turn_sin_ * y),
                       origin_y_px_ + px_per_m_ * (turn_sin_ * x + turn_cos_ * y));
  if (!slant_.is_none()) seen = foot_px_ + slant_.apply(Eigen::Vector2d(seen - foot_px_));
  return {seen.x(), sensor_.height - 1.0 - seen.y()};
}

Vec3 Optics::from_surface(double x_m, double y_m, double off_plane_m) const {
  return {mirrored_ ? -x_m : x_m, y_m - half_height_m_, off_plane_m};
}

}  // namespace strobe::sim
