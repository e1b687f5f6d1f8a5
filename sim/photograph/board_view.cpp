#include "sim/photograph/board_view.hpp"

#include "sim/photograph/optics.hpp"

namespace strobe::sim {
namespace {

constexpr double kFar_m = 100.0;

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
  return view;
}

}  // namespace strobe::sim
