// Calibrations against cameras of known truth: scale, tilt, lens, place; and whether the stated sd is true.
#include "host/camera/calibration.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tests/host/camera/pinhole.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using camera::BoardKind;
using camera::BoardPattern;
using testing::Pinhole;
using testing::Pose;

namespace {

/// Distances on the plane, as the map and the scale say them, against the board's own.
double worst_distance_error(const camera::Calibration& found, const Pinhole& truth, const Pose& pose,
                            const BoardPattern& pattern) {
  const double w = pattern.spacing_m * (pattern.columns - 1), h = pattern.spacing_m * (pattern.rows - 1);
  const std::vector<cv::Point2d> corners{{0, 0}, {w, 0}, {0, h}, {w, h}, {0.5 * w, 0.5 * h}};
  const auto map = found.map();
  double worst = 0.0;
  for (const cv::Point2d& a : corners) {
    for (const cv::Point2d& b : corners) {
      if (a == b) continue;
      const cv::Point2d p = map.to_plane(truth.project(pose.to_camera(a)));
      const cv::Point2d q = map.to_plane(truth.project(pose.to_camera(b)));
      worst = std::max(worst, std::abs(cv::norm(p - q) / found.px_per_m / cv::norm(a - b) - 1.0));
    }
  }
  return worst;
}

}  // namespace

TEST_GROUP(Calibration) {
  BoardPattern board{BoardKind::chessboard, 9, 6, 0.02};
  Pinhole pinhole{640, 480, 2500.0, -0.25, 0.0, {319.5, 239.5}};
  camera::CalibrationSettings settings{640, 480, 0.0, 0.0, {}, {}};
  std::mt19937_64 random{20261121};

  std::vector<camera::BoardView> slanted(const Pose& plane, double noise_px) {
    std::vector<camera::BoardView> views{testing::view(pinhole, plane, board, noise_px, random)};
    for (const cv::Vec3d& turns : {cv::Vec3d(0.5, 0.0, 0.0), cv::Vec3d(-0.5, 0.1, 0.0),
                                   cv::Vec3d(0.0, 0.5, 0.1), cv::Vec3d(0.1, -0.5, 0.0)})
      views.push_back(testing::view(pinhole, testing::pose(board, 1.0, turns), board, noise_px, random));
    return views;
  }
};

TEST(Calibration, OfASinglePhotographUndoesTiltAndLens) {
  const Pose tilted = testing::pose(board, 0.9, {0.05, -0.04, 0.03});
  const auto view = testing::view(pinhole, tilted, board, 0.0, random);
  const auto found = camera::calibrate({&view, 1}, settings);
  CHECK_TRUE(found.has_value());
  // Without noise the model is exact: what is left is the iteration's end.
  CHECK_TRUE(worst_distance_error(*found, pinhole, tilted, board) < 1e-7);
  DOUBLES_EQUAL(2500.0 / 0.9, found->px_per_m, 5.0);
}

TEST(Calibration, KeepsThePhotographsAxesAtItsCentre) {
  for (const double roll : {0.02, 1.6, 3.1}) {  // whichever way the board was held
    const auto view = testing::view(pinhole, testing::pose(board, 1.2, {0.0, 0.0, roll}), board, 0.0, random);
    const auto map = camera::calibrate({&view, 1}, settings)->map();
    const cv::Matx22d d = map.jacobian({319.5, 239.5});
    DOUBLES_EQUAL(1.0, d(0, 0), 1e-6);
    DOUBLES_EQUAL(0.0, d(0, 1), 1e-6);
    DOUBLES_EQUAL(0.0, d(1, 0), 1e-6);
    DOUBLES_EQUAL(-1.0, d(1, 1), 1e-6);
    DOUBLES_EQUAL(239.5, map.to_plane({319.5, 239.5}).y, 1e-6);
  }
}

TEST(Calibration, OfSlantedBoardsFindsTheLens) {
  const Pose plane = testing::pose(board, 0.9, {0.03, 0.02, 0.0});
  const auto found = camera::calibrate(slanted(plane, 0.02), settings);
  CHECK_TRUE(found.has_value() && found->place.has_value());
  const auto& place = *found->place;
  const double sd_m = place.distance_sd_px / found->px_per_m;
  CHECK_TRUE(sd_m < 0.01);
  DOUBLES_EQUAL(plane.distance_m(), place.viewpoint.distance_px / found->px_per_m, 4.0 * sd_m);
  DOUBLES_EQUAL(std::hypot(0.03, 0.02), place.tilt_rad, 0.004);
  const cv::Point2d foot = found->map().to_plane(pinhole.project(plane.to_camera(plane.foot_m())));
  CHECK_TRUE(cv::norm(foot - place.viewpoint.foot_px) < 10.0);  // 0.2 degree as seen from the lens
  DOUBLES_EQUAL(-0.25, found->lens.k1 * std::pow(2500.0 / found->lens.focal_px, 2.0), 0.02);
}

TEST(Calibration, OfASlightTiltDoesNotTakeALensOffCentreForADistance) {
  pinhole.centre = {322.0, 237.5};
  const Pose plane = testing::pose(board, 0.9, {0.03, 0.03, 0.0});
  const auto view = testing::view(pinhole, plane, board, 0.002, random);
  const auto found = camera::calibrate({&view, 1}, settings);
  if (found->place) {
    DOUBLES_EQUAL(plane.distance_m(), found->place->viewpoint.distance_px / found->px_per_m,
                  3.0 * found->place->distance_sd_px / found->px_per_m);
  }
}

TEST(Calibration, OfOneStraightPhotographLeavesTheDistanceToATape) {
  const auto view = testing::view(pinhole, testing::pose(board, 1.0, {0.0, 0.0, 0.0}), board, 0.05, random);
  settings.off_plane_sd_m = 0.001;
  const auto without = camera::calibrate({&view, 1}, settings);
  CHECK_FALSE(without->place.has_value());
  CHECK_FALSE(without->remarks.empty());
  settings.lens_distance_m = 1.0;
  settings.lens_distance_sd_m = 0.01;
  const auto with = camera::calibrate({&view, 1}, settings);
  DOUBLES_EQUAL(1.0, with->place->viewpoint.distance_px / with->px_per_m, 0.03);
  DOUBLES_EQUAL(0.001, *with->scale_errors.off_plane, 1e-4);
  CHECK_TRUE(with->px_per_m_sd() > 0.99 * 0.001 * with->px_per_m);
}

TEST(Calibration, StatesTheScalesErrorTruly) {
  // 60 calibrations; the sd of a sum of 60·9 correlated squares: with three independent places at least 180,
  // so that the rms is within 1 ± 3/sqrt(360).
  const Pose plane = testing::pose(board, 0.9, {0.04, -0.05, 0.02});
  settings.spacing_sd_share = 0.0;
  double sum = 0.0;
  int n = 0;
  for (int i = 0; i < 60; ++i) {
    const auto view = testing::view(pinhole, plane, board, 0.1, random);
    const auto found = camera::calibrate({&view, 1}, settings);
    const auto map = found->map();
    for (const double fx : {0.1, 0.5, 0.9}) {
      for (const double fy : {0.1, 0.5, 0.9}) {
        // A hundredth of a pixel either way along x and y, through the truth to the board.
        const cv::Point2d at(639.0 * fx, 479.0 * fy);
        const auto board_at = [&](cv::Point2d p) {
          const cv::Point2d ray = pinhole.ray(p);
          const cv::Vec3d direction = plane.turn.t() * cv::Vec3d(ray.x, ray.y, 1.0);
          const cv::Vec3d lens = plane.turn.t() * plane.shift * -1.0;
          const cv::Vec3d hit = lens - direction * (lens[2] / direction[2]);
          return cv::Point2d(hit[0], hit[1]);
        };
        const cv::Point2d dx = board_at(at + cv::Point2d(0.01, 0)) - board_at(at - cv::Point2d(0.01, 0));
        const cv::Point2d dy = board_at(at + cv::Point2d(0, 0.01)) - board_at(at - cv::Point2d(0, 0.01));
        const double true_area = std::abs(dx.cross(dy)) / 4e-4;
        const double px_area = std::abs(cv::determinant(map.jacobian(at)));
        const double share = 0.5 * std::log(px_area / (true_area * found->px_per_m * found->px_per_m));
        sum += share * share / std::pow(found->scale_errors.points, 2.0);
        ++n;
      }
    }
  }
  const double rms = std::sqrt(sum / n);
  // This lens is nearer to a plain one than the priors allow for, which is why the lower end is lower.
  CHECK_TRUE_TEXT(rms > 0.6 && rms < 1.16, fmt::format("normalized errors' rms {}", rms).c_str());
}

TEST(Calibration, SaysWhatItCannotDo) {
  camera::BoardView few{"few.png", {{0, 0}, {1, 0}, {0, 1}}, {{10, 10}, {20, 10}, {10, 20}}};
  STRCMP_CONTAINS("few.png: less than 9 points",
                  camera::calibrate({&few, 1}, settings).error().message.c_str());
  STRCMP_CONTAINS("no photograph", camera::calibrate({}, settings).error().message.c_str());
  camera::BoardView line{"line.png", {}, {}};
  for (int i = 0; i < 20; ++i) {
    line.board_m.emplace_back(0.01 * i, 0.0);
    line.image_px.emplace_back(10.0 * i, 5.0);
  }
  CHECK_FALSE(camera::calibrate({&line, 1}, settings).has_value());
}

TEST(Calibration, LeavesAPointOutThatIsFarOff) {
  const Pose plane = testing::pose(board, 0.9, {0.05, -0.04, 0.03});
  auto view = testing::view(pinhole, plane, board, 0.02, random);
  view.image_px[20].x += 3.0;
  const auto found = camera::calibrate({&view, 1}, settings);
  LONGS_EQUAL(1, found->fit.outliers);
  CHECK_TRUE(found->fit.rms_px < 0.03);
}

TEST_GROUP(Board) {
  Pinhole pinhole{640, 480, 2500.0, -0.25, 0.0, {319.5, 239.5}};
  std::mt19937_64 random{7};

  double rms_of(const BoardPattern& pattern, const Pose& pose) {
    digitize::Photograph photograph;
    photograph.name = "board.png";
    photograph.intensity = testing::photograph(pinhole, pose, pattern, 0.01, random);
    const auto seen = camera::find_board(photograph, pattern);
    CHECK_TRUE_TEXT(seen.has_value(), seen ? "" : seen.error().message.c_str());
    // The board may be read from any of its corners: the map from it to the truth's points is what counts.
    const camera::CalibrationSettings settings{640, 480, 0.0, 0.0, {}, {}};
    const auto found = camera::calibrate({&*seen, 1}, settings);
    CHECK_TRUE(found.has_value());
    const double worst = worst_distance_error(*found, pinhole, pose, pattern);
    // 28 discs that cover a tenth of the photograph leave more open than a chessboard does.
    CHECK_TRUE_TEXT(worst < std::max(3e-4, found->scale_errors.points), fmt::format("{}", worst).c_str());
    return found->fit.rms_px;
  }
};

TEST(Board, ChessboardsCornersAreFoundToPartsOfAPixel) {
  const BoardPattern pattern{BoardKind::chessboard, 9, 6, 0.02};
  CHECK_TRUE(rms_of(pattern, testing::pose(pattern, 1.0, {0.1, -0.1, 0.05})) < 0.1);
}

TEST(Board, DiscsAreFoundToPartsOfAPixel) {
  const BoardPattern pattern{BoardKind::circles, 8, 6, 0.02};
  CHECK_TRUE(rms_of(pattern, testing::pose(pattern, 1.0, {0.02, -0.03, 0.05})) < 0.1);
}

TEST(Board, StaggeredDiscsAreFoundToPartsOfAPixel) {
  const BoardPattern pattern{BoardKind::staggered_circles, 4, 7, 0.04};
  CHECK_TRUE(rms_of(pattern, testing::pose(pattern, 1.0, {0.02, -0.03, 0.05})) < 0.1);
}

TEST(Board, ThatIsNotThereIsSaidSo) {
  digitize::Photograph photograph;
  photograph.name = "empty.png";
  photograph.intensity = cv::Mat(120, 160, CV_32FC1, cv::Scalar(0.5));
  STRCMP_CONTAINS("empty.png: no chessboard 9 x 6, 20 mm is seen as a whole",
                  camera::find_board(photograph, {}).error().message.c_str());
}
