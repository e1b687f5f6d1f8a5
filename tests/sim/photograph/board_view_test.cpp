#include "sim/photograph/board.hpp"

#include <cmath>
#include <string>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/appearance.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

TEST_GROUP(BoardView) {
  const Board board{BoardPrint::chessboard, 9, 6, 0.03};

  /// The largest difference between two places' distances in the plane, by the board's camera and by the scene's.
  double worst_m(const std::string& name) const {
    const auto scene = load_scene(name);
    CHECK_TRUE(scene.has_value());
    return worst_m(*scene);
  }
  double worst_m(const Scene& scene) const {
    const Optics optics(scene);
    const BoardView view = board_view(scene);
    double worst = 0.0;
    for (const double row : {0.1, 0.5, 0.9}) {
      for (const double column : {0.1, 0.4, 0.9}) {
        const double x = column * view.camera.width_px, y = row * view.camera.height_px;
        const double x0 = 0.5 * view.camera.width_px, y0 = 0.5 * view.camera.height_px;
        const Vec2 here = optics.plane_at(x, y), middle = optics.plane_at(x0, y0);
        const cv::Point2d there = board_at(view.camera, board, view.place, {x, y}) -
                                  board_at(view.camera, board, view.place, {x0, y0});
        worst = std::max(worst, std::abs(std::hypot(here.x - middle.x, here.y - middle.y) - cv::norm(there)));
      }
    }
    return worst;
  }
};

// 1e-9 m is some millionth of a px; the inverse of the distortion is found to 1e-10 or better by either camera.
TEST(BoardView, PlaneIsAsLargeAsTheScenesCameraSeesIt) {
  for (const char* name : {"zero_23", "photo_tilted", "photo_close_lens", "photo_small"})
    CHECK_TEXT(worst_m(name) < 1e-9, name);
}

TEST(BoardView, IsATurnedCamerasAsWell) {
  auto scene = load_scene("photo_close_lens");
  scene->camera.distortion = 0.0;
  scene->camera.swing_rad = 0.05;
  scene->camera.tilt_rad = -0.03;
  CHECK(worst_m(*scene) < 1e-9);
}

TEST(BoardView, BoardIsInTheMiddleOfThePhotograph) {
  const auto scene = load_scene("photo_small");
  const BoardView view = board_view(*scene);
  const cv::Point2d corner = image_of(view.camera, board, view.place, {0.0, 0.0});
  const cv::Point2d opposite = image_of(view.camera, board, view.place, {8 * 0.03, 5 * 0.03});
  // Within a px: the lens is 100 m away and bends nothing.
  DOUBLES_EQUAL(0.5 * (view.camera.width_px - 1), 0.5 * (corner.x + opposite.x), 1.0);
  DOUBLES_EQUAL(0.5 * (view.camera.height_px - 1), 0.5 * (corner.y + opposite.y), 1.0);
}
