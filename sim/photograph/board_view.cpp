#include "sim/photograph/board_view.hpp"

#include <cmath>
#include <numbers>

#include "sim/photograph/optics.hpp"
#include "sim/rig/slant.hpp"

namespace strobe::sim {
namespace {

constexpr double kFar_m = 100.0;
constexpr double kDegrees = 180.0 / std::numbers::pi;

/// The board as the turned camera has it before itself: x right, y down.
void turn(const Slant& slant, BoardView& view) {
  const Eigen::Vector3d down(1.0, -1.0, 1.0);
  const Eigen::Matrix3d r = down.asDiagonal() * slant.rotation() * down.asDiagonal();
  const Eigen::Vector3d middle =
      r * Eigen::Vector3d(view.place.aside_m[0], view.place.aside_m[1], view.place.distance_m);
  view.place.aside_m = {middle.x(), middle.y()};
  view.place.distance_m = middle.z();
  // Of a turn about x, then y, then z.
  view.place.turns_deg = {kDegrees * std::atan2(r(2, 1), r(2, 2)), -kDegrees * std::asin(r(2, 0)),
                          kDegrees * std::atan2(r(1, 0), r(0, 0))};
  view.camera.lens_aside_px[0] += slant.shift_px().x();
  view.camera.lens_aside_px[1] -= slant.shift_px().y();
}

}  // namespace

BoardView board_view(const Scene& scene) {
  const Optics optics(scene);
  const CameraSettings& from = scene.camera;
  const double distance_m = optics.perspective() ? optics.distance_m() : kFar_m;
  const double corner_m2 = from.half_width_m * from.half_width_m + 0.25 * from.height_m * from.height_m;
  const Vec2 foot = optics.image_of({0.0, 0.0, 0.0});
  BoardView view;
  view.camera.width_px = optics.sensor().width;
  view.camera.height_px = optics.sensor().height;
  view.camera.focal_px = optics.px_per_m() * distance_m;
  // The scene's is of the distance in the plane, in half diagonals of the view; OpenCV's of the tangent.
  view.camera.lens = {from.distortion * distance_m * distance_m / corner_m2, 0.0, 0.0, 0.0};
  view.camera.lens_aside_px = {foot.x - 0.5 * (view.camera.width_px - 1),
                               foot.y - 0.5 * (view.camera.height_px - 1)};
  view.place.distance_m = distance_m;
  view.place.aside_m = {-view.camera.lens_aside_px[0] / optics.px_per_m(),
                        -view.camera.lens_aside_px[1] / optics.px_per_m()};
  if (from.turned()) turn(Slant(from.swing_rad, from.tilt_rad, view.camera.focal_px), view);
  return view;
}

}  // namespace strobe::sim
