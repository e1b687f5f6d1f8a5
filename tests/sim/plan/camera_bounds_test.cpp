#include "sim/plan/camera_bounds.hpp"

#include <cmath>
#include <numbers>

#include "sim/plan/nominal_shot.hpp"
#include "sim/rig/pixels.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

namespace {

Scene lens_scene() {
  Scene scene;
  scene.camera.distance_m = 1.2;
  scene.camera.distortion = 0.05;
  scene.camera.mirrored = true;
  scene.camera.roll_rad = 0.03;
  return scene;
}

Camera camera(const Scene& scene, bool perspective, bool distortion) {
  Scene left = scene;
  if (!perspective) left.camera.distance_m = 0.0;
  if (!distortion) left.camera.distortion = 0.0;
  return Camera(left);
}

double length_m(const Scene& scene, const strobe::reduction::PointPx& a,
                const strobe::reduction::PointPx& b) {
  return std::hypot(a.x - b.x, a.y - b.y) / scene.camera.px_per_m;
}

}  // namespace

TEST_GROUP(CameraBounds){};

TEST(CameraBounds, OfTheLensHoldForViewsWithAndWithoutTheOtherEffect) {
  const Scene scene = lens_scene();
  const CameraBounds bounds(scene);
  for (const double x : {-0.3, 0.05, 0.3}) {
    for (const double z : {-0.06, 0.0, 0.06}) {
      for (int k = 0; k < 12; ++k) {
        const double angle = k * std::numbers::pi / 12.0;
        for (const bool other : {false, true}) {
          for (const Effect effect : {Effect::perspective, Effect::lens_distortion}) {
            const bool perspective = effect == Effect::perspective;
            const BallView with =
                camera(scene, perspective || other, !perspective || other).view(x, 0.3, z, angle);
            const BallView less =
                camera(scene, !perspective && other, perspective && other).view(x, 0.3, z, angle);
            const BoundedDisplacement d = bounds.of_ball(effect, x, 0.3, z, angle);
            const double moved = length_m(scene, with.centre_px, less.centre_px);
            const double room = std::hypot(d.by.x_m, d.by.y_m) + std::hypot(d.within.x_m, d.within.y_m);
            CHECK_TRUE(moved <= room);
            const double wider = (with.diameter_px() - less.diameter_px()) / scene.camera.px_per_m;
            CHECK_TRUE(std::abs(wider - d.by.diameter_m) <= d.within.diameter_m + 1e-15);
            const double turned = std::remainder(with.equator_rad - less.equator_rad, std::numbers::pi);
            CHECK_TRUE(std::abs(turned) <= d.within.equator_rad);
          }
        }
      }
    }
  }
}

TEST(CameraBounds, AreInTheDirectionOfTravel) {
  Scene scene = lens_scene();
  scene.camera.distance_m = 0.0;
  const CameraBounds bounds(scene);
  // Outwards, above the axis and after the impact: on along the ball's way, and up.
  const BoundedDisplacement d = bounds.of_ball(Effect::lens_distortion, 0.2, 0.3, 0.0, 0.0);
  CHECK_TRUE(d.by.x_m > 0.0);
  CHECK_TRUE(d.by.y_m > 0.0);
}

TEST(CameraBounds, OfPixelsHoldForPicturesMeasured) {
  Scene scene;
  scene.camera.pixels = true;
  PixelGrid grid;
  for (const double px_per_m : {300.0, 1200.0, 4000.0}) {
    scene.camera.px_per_m = px_per_m;
    const CameraBounds bounds(scene);
    const Camera points(scene);
    for (int k = 0; k < 60; ++k) {
      const double x = 0.0013 * k, angle = 0.11 * k;
      const BallView view = points.view(x, 0.1 + 0.0007 * k, 0.0, angle);
      const PixelMeasurement seen = grid.measure(view, {});
      const BoundedDisplacement d = bounds.of_ball(Effect::pixels, x, 0.1, 0.0, angle);
      CHECK_TRUE(length_m(scene, seen.centre_px, view.centre_px) <= std::hypot(d.within.x_m, d.within.y_m));
      CHECK_TRUE(std::abs(seen.diameter_px - view.diameter_px()) <= d.within.diameter_m * px_per_m);
      CHECK_TRUE(std::abs(std::remainder(*seen.equator_rad - view.equator_rad, std::numbers::pi)) <=
                 d.within.equator_rad);
    }
  }
}

TEST(CameraBounds, OfASmearHoldForPicturesOfABallInMotion) {
  Scene scene;
  scene.camera.pixels = true;
  scene.lamps.flash_s = 60e-6;
  const CameraBounds bounds(scene);
  const Camera points(scene);
  PixelGrid grid;
  for (int k = 0; k < 24; ++k) {
    const BallView view = points.view(0.01, 0.1, 0.0, k * std::numbers::pi / 24.0);
    const double way_px = 30.0 * scene.lamps.flash_s * scene.camera.px_per_m;
    const auto still = grid.measure(view, {});
    const auto moving = grid.measure(view, {0.8 * way_px, -0.6 * way_px, 0.0});
    const double turned =
        std::abs(std::remainder(*moving.equator_rad - *still.equator_rad, std::numbers::pi));
    const BoundedDisplacement pixels = bounds.of_ball(Effect::pixels, 0.01, 0.1, 0.0, 0.0);
    CHECK_TRUE(turned <= bounds.motion_blur_rad(30.0) + 2.0 * pixels.within.equator_rad);
  }
}

TEST(CameraBounds, HaveNoBoundForABallTooSmallForItsEquator) {
  Scene scene;
  scene.camera.pixels = true;
  scene.camera.px_per_m = 150.0;  // 9.8 px
  CHECK_TRUE(std::isinf(CameraBounds(scene).of_ball(Effect::pixels, 0.0, 0.1, 0.0, 0.0).within.equator_rad));
}
