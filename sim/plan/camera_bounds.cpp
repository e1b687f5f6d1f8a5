#include "sim/plan/camera_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/plan/displacement.hpp"
#include "sim/rig/pixels.hpp"
#include "sim/scene/reduced_scene.hpp"

namespace strobe::sim {

namespace {

constexpr double kFlat = 1.0 / (2.0 * PixelGrid::kLines);

Scene studied(const Scene& scene, Effect left_out) {
  return reduced_scene(scene, Model::full().without(left_out).without(Effect::pixels));
}

}  // namespace

CameraBounds::CameraBounds(const Scene& scene)
    : scene_(scene),
      full_(studied(scene, Effect::pixels)),
      without_perspective_(studied(scene, Effect::perspective)),
      without_distortion_(studied(scene, Effect::lens_distortion)),
      turn_cos_(std::cos(full_.project_angle(0.0))),
      turn_sin_(std::sin(full_.project_angle(0.0))),
      side_(scene.camera.mirrored ? -1.0 : 1.0) {}

const Camera* CameraBounds::without(Effect effect) const {
  if (effect == Effect::perspective && scene_.camera.distance_m > 0.0) return &without_perspective_;
  if (effect == Effect::lens_distortion && scene_.camera.distortion != 0.0) return &without_distortion_;
  return nullptr;
}

Displacement CameraBounds::on_object(double dx_px, double dy_px) const {
  const double scale = scene_.camera.px_per_m;
  return {.x_m = side_ * (turn_cos_ * dx_px + turn_sin_ * dy_px) / scale,
          .y_m = (turn_cos_ * dy_px - turn_sin_ * dx_px) / scale};
}

double CameraBounds::product_of_shares(double x_m, double y_m, double off_plane_m) const {
  const CameraSettings& c = scene_.camera;
  if (c.distance_m <= 0.0 || c.distortion == 0.0) return 0.0;
  const double radius = scene_.ball.radius_m();
  const double y = y_m - 0.5 * c.height_m;
  const double square = x_m * x_m + y * y + radius * radius;
  const double depth = c.distance_m - std::abs(off_plane_m);
  const double half_diagonal_square = c.half_width_m * c.half_width_m + 0.25 * c.height_m * c.height_m;
  const double perspective = std::abs(off_plane_m) / depth + square / (depth * depth);
  return 2.0 * perspective * 3.0 * std::abs(c.distortion) * square / half_diagonal_square;
}

double CameraBounds::rotation_rad(Effect effect, double x_m, double y_m, double off_plane_m) const {
  const CameraSettings& c = scene_.camera;
  const double y = y_m - 0.5 * c.height_m;
  const double square = x_m * x_m + y * y;
  if (effect == Effect::perspective) {
    const double depth = c.distance_m - std::abs(off_plane_m);
    const double share = square / (depth * depth);
    return 0.5 * share * (1.0 + share) + scene_.ball.radius_m() * std::sqrt(square) / (depth * depth);
  }
  const double half_diagonal_square = c.half_width_m * c.half_width_m + 0.25 * c.height_m * c.height_m;
  const double share = std::abs(c.distortion) * square / half_diagonal_square;
  return share / std::max(0.1, 1.0 - 2.0 * share);
}

BoundedDisplacement CameraBounds::of_ball(Effect effect, double x_m, double y_m, double off_plane_m,
                                          double equator_rad) const {
  if (effect == Effect::pixels && scene_.camera.pixels)
    return of_pixels(full_.view(x_m, y_m, off_plane_m, equator_rad).diameter_px());
  const Camera* other = without(effect);
  if (!other) return {};
  const BallView with = full_.view(x_m, y_m, off_plane_m, equator_rad);
  const BallView less = other->view(x_m, y_m, off_plane_m, equator_rad);
  BoundedDisplacement d;
  d.by = on_object(with.centre_px.x - less.centre_px.x, with.centre_px.y - less.centre_px.y);
  d.by.diameter_m = (with.diameter_px() - less.diameter_px()) / scene_.camera.px_per_m;
  const double shares = product_of_shares(x_m, y_m, off_plane_m);
  const double far_m = std::hypot(x_m, y_m - 0.5 * scene_.camera.height_m) + scene_.ball.radius_m();
  d.within = {shares * far_m, shares * far_m, shares * scene_.ball.diameter_m,
              shares + rotation_rad(effect, x_m, y_m, off_plane_m), 0.0};
  return d;
}

BoundedDisplacement CameraBounds::of_surface(Effect effect, double x_m, double dx_px, double dy_px) const {
  if (!without(effect)) return {};
  BoundedDisplacement d;
  d.by = on_object(dx_px, dy_px);
  const double far_m = std::hypot(x_m, 0.5 * scene_.camera.height_m);
  d.within.x_m = d.within.y_m = product_of_shares(x_m, 0.0, 0.0) * far_m;
  return d;
}

BoundedDisplacement CameraBounds::of_pixels(double diameter_px) const {
  BoundedDisplacement d;
  // A little less and a little more than drawn: what else is left out may change the size.
  if (1.1 * diameter_px < PixelGrid::kSmallest_px || 0.9 * diameter_px > PixelGrid::kLargest_px) return d;
  const double r = 0.5 * diameter_px;
  const double scale = scene_.camera.px_per_m;
  const double outline = (8.0 * r + 8.0) / (2.0 * PixelGrid::kBall) + 4.0 * std::sqrt(2.0 * r) * kFlat;
  d.within.x_m = d.within.y_m = (r + 1.0) * outline / (std::numbers::pi * r * r) / scale;
  d.within.diameter_m = outline / (std::numbers::pi * r) / scale;
  const double bar = (5.3 * r + 8.0) / (2.0 * (PixelGrid::kBall - PixelGrid::kBar)) + 2.4 * r * kFlat;
  d.within.equator_rad = 0.6 * r * (0.06 * r + 1.0) * bar / (0.0171 * r * r * r * r);
  if (0.9 * diameter_px < PixelGrid::kSmallestWithLine_px) d.within.equator_rad = kNoBound;
  return d;
}

double CameraBounds::motion_blur_rad(double speed_mps) const {
  if (!scene_.camera.pixels) return 0.0;
  const double displacement_m = speed_mps * scene_.lamps.flash_s;
  const double share =
      displacement_m * displacement_m / 12.0 / (0.119 * scene_.ball.radius_m() * scene_.ball.radius_m());
  return share < 0.5 ? 0.5 * share / (1.0 - share) : std::numbers::pi / 2.0;
}

}  // namespace strobe::sim
