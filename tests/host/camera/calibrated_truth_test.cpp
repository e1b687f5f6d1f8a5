// Whether what a calibration leaves open is true: of points all over the photograph, and of a readout through its map.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

#include "common/reduction/reduce.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/camera/calibration.hpp"
#include "sim/photograph/board.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using digitize::PlaneMap;
using reduction::Quantity;

namespace {

constexpr int kWidth = 640, kHeight = 512;
const double kDiagonal = std::hypot(kWidth, kHeight);

/// What the calibration file says of it.
host::CameraTable table_of(const camera::Calibration& found) {
  host::CameraTable table;
  camera::set_map(found, table);
  return table;
}

/// Board metres to plane px, as the calibration laid them down.
cv::Matx33d to_plane(const camera::Calibration& found) {
  const double f = found.lens.focal_px;
  const cv::Point2d c = found.lens.centre_px;
  const cv::Matx33d normalize(1.0 / f, 0.0, -c.x / f, 0.0, 1.0 / f, -c.y / f, 0.0, 0.0, 1.0);
  const cv::Matx33d similarity = found.rectify * (found.fit.homographies[0].inv() * normalize).inv();
  return similarity * (1.0 / similarity(2, 2));
}

cv::Point2d apply(const cv::Matx33d& h, cv::Point2d p) {
  const cv::Vec3d q = h * cv::Vec3d(p.x, p.y, 1.0);
  return {q[0] / q[2], q[1] / q[2]};
}

/// Squared error of a mapped place, normalized by what its map leaves open; 2 on average.
double chi_square(const host::CameraTable& table, cv::Point2d image_px, cv::Point2d truth_px) {
  const PlaneMap map = host::plane_map(table, kHeight);
  const cv::Point2d at = map.to_plane(image_px);
  reduction::Frame point;
  point.surface_px = {{at.x, at.y}};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  host::set_calibration(table, point);
  for (const auto& error : point.map_errors) {
    const Eigen::Vector2d moved(error.surface_px[0].x, error.surface_px[0].y);
    covariance += moved * moved.transpose();
  }
  const Eigen::Vector2d off(at.x - truth_px.x, at.y - truth_px.y);
  return off.dot(covariance.ldlt().solve(off));
}

const std::vector<cv::Point2d> kCorners{{0, 0}, {kWidth - 1, 0}, {0, kHeight - 1}, {kWidth - 1, kHeight - 1}};

}  // namespace

TEST_GROUP(CalibratedTruth) {
  std::mt19937_64 random{test::seed_or(16)};
  std::normal_distribution<double> normal;
  sim::BoardCamera camera;
  sim::Board board{sim::BoardPrint::chessboard, 9, 6, 0.03};
  sim::BoardPlace place;
  camera::CalibrationSettings settings{kWidth, kHeight, 0.0, 0.0, {}, {}};

  void setup() override {
    camera.width_px = kWidth;
    camera.height_px = kHeight;
    camera.focal_px = 1284.0;
    settings.tolerance_share = 0.1;
  }

  /// A lens as the priors say that lenses are: terms for a unit of the diagonal, here of the focal length.
  void draw_lens() {
    const double unit = camera.focal_px / kDiagonal;
    const auto& sd = camera::kLensPriorSds;
    camera.lens = {sd[0] * normal(random) * std::pow(unit, 2.0), sd[1] * normal(random) * std::pow(unit, 4.0),
                   sd[2] * normal(random) * unit, sd[3] * normal(random) * unit};
    place.turns_deg = {2.0 * normal(random), 2.0 * normal(random), normal(random)};
  }

  camera::BoardView exact_view(double noise_px) {
    camera::BoardView view;
    view.name = "board";
    for (int row = 0; row < board.rows; ++row) {
      for (int column = 0; column < board.columns; ++column) {
        view.board_m.emplace_back(board.spacing_m * column, board.spacing_m * row);
        const cv::Point2d at = sim::image_of(camera, board, place, view.board_m.back());
        view.image_px.emplace_back(at.x + noise_px * normal(random), at.y + noise_px * normal(random));
      }
    }
    return view;
  }

  double corners_chi_square(const camera::Calibration& found) {
    const host::CameraTable table = table_of(found);
    double sum = 0.0;
    for (const cv::Point2d& corner : kCorners)
      sum += chi_square(table, corner, apply(to_plane(found), sim::board_at(camera, board, place, corner)));
    return sum;
  }
};

TEST(CalibratedTruth, MappedCornersAreAsFarOffAsTheirCovarianceSays) {
  // Boards over 7 and 40 % of the photograph. 60 calibrations of 8 coordinates, which share 12 errors: of at least 120
  // independent squares the mean is within 1 ± 3 sqrt(2 / 120), from both sides.
  for (const double spacing_m : {0.0125, 0.03}) {
    board.spacing_m = spacing_m;
    double sum = 0.0;
    for (int i = 0; i < 60; ++i) {
      draw_lens();
      const auto view = exact_view(0.05);
      sum += corners_chi_square(*camera::calibrate({&view, 1}, settings)) / 8.0 / 60.0;
    }
    CHECK_TRUE_TEXT(
        sum > 0.61 && sum < 1.39,
        fmt::format("{} m: mean normalized square {}, repeat with STROBE_SEED", spacing_m, sum).c_str());
  }
}

TEST(CalibratedTruth, OfPhotographedBoardsToo) {
  // Ten photographs: of at least 30 independent squares. Noise of corners is not quite independent of place, which the
  // upper bound leaves room for.
  double sum = 0.0;
  constexpr int kPhotographs = 10;
  for (int i = 0; i < kPhotographs; ++i) {
    draw_lens();
    camera.noise = 0.03;
    const auto shown = sim::photograph_board(camera, board, place, static_cast<std::uint64_t>(i));
    digitize::Photograph photograph;
    photograph.name = "board";
    shown.pixels.convertTo(photograph.intensity, CV_32F, 1.0 / 65535.0);
    auto view = camera::find_board(photograph, {camera::BoardKind::chessboard, 9, 6, board.spacing_m});
    CHECK_TRUE_TEXT(view.has_value(), view ? "" : view.error().message.c_str());
    // It may have been read from the other end; the truth counts from the first.
    const cv::Point2d first = shown.image_px.front();
    if (cv::norm(view->image_px.front() - first) > cv::norm(view->image_px.back() - first))
      std::ranges::reverse(view->image_px);
    sum += corners_chi_square(*camera::calibrate({&*view, 1}, settings)) / 8.0 / kPhotographs;
  }
  CHECK_TRUE_TEXT(sum > 0.3 && sum < 2.5, fmt::format("mean normalized square {}", sum).c_str());
}

TEST(CalibratedTruth, AReadoutsErrorsThroughTheMapAreAsStated) {
  // mu of one exact shot through 60 calibrations by boards over 40 %: the rms is within 1 ± 3 / sqrt(120).
  board.spacing_m = 0.03;
  test::Setup exact;
  exact.noise_factor = 0.0;
  test::Random none(1);
  const reduction::Frame ideal = test::photograph({}, exact, none);
  const double truth = *reduce(ideal, reduction::Estimator::best)->value[Quantity::mu];
  DOUBLES_EQUAL(*test::truth({})[Quantity::mu], truth, 1e-4);
  double sum = 0.0;
  int outliers = 0;
  for (int i = 0; i < 60; ++i) {
    draw_lens();
    const auto view = exact_view(0.05);
    const auto found = *camera::calibrate({&view, 1}, settings);
    const host::CameraTable table = table_of(found);
    const PlaneMap map = found.map();
    // The ideal photograph, 4000 px/m about (1200, 300), laid on the board so that its middle is the photograph's.
    const auto seen = [&](reduction::PointPx p) {
      const cv::Point2d on_board((p.x - 1200.0) / 4000.0 + 0.12, 0.15 - (p.y - 300.0) / 4000.0);
      return map.to_plane(sim::image_of(camera, board, place, on_board));
    };
    reduction::Frame frame = ideal;
    for (reduction::BallImage& image : frame.images) {
      const cv::Point2d centre = seen(image.centre_px),
                        side = seen({image.centre_px.x + 1.0, image.centre_px.y});
      const cv::Point2d up = seen({image.centre_px.x, image.centre_px.y + 1.0});
      image.diameter_px *= std::sqrt(std::abs((side - centre).cross(up - centre)));
      const double c = std::cos(*image.equator_rad), s = std::sin(*image.equator_rad);
      const cv::Point2d along = (side - centre) * c + (up - centre) * s;
      image.equator_rad = std::atan2(along.y, along.x);
      image.centre_px = {centre.x, centre.y};
    }
    for (reduction::PointPx& p : frame.surface_px) {
      const cv::Point2d at = seen(p);
      p = {at.x, at.y};
    }
    // So exactly seen that the map alone matters, but not so that its bends would be outliers.
    frame.centre_sd_px = frame.surface_sd_px = frame.diameter_sd_px = 0.5;
    frame.px_per_m = found.px_per_m;
    frame.px_per_m_sd = 1e-3 * found.px_per_m;
    const double without = *reduce(frame, reduction::Estimator::best)->sd[Quantity::mu];
    host::set_calibration(table, frame);
    const auto readout = *reduce(frame, reduction::Estimator::best);
    const double sd = *readout.sd[Quantity::mu];
    sum += std::pow(*readout.value[Quantity::mu] - truth, 2.0) / (sd * sd - without * without) / 60.0;
    outliers += readout.flags.has(reduction::Flag::outlier_image) ? 1 : 0;
  }
  LONGS_EQUAL(0, outliers);
  const double rms = std::sqrt(sum);
  CHECK_TRUE_TEXT(rms > 0.73 && rms < 1.27, fmt::format("normalized rms of mu {}", rms).c_str());
}

TEST(CalibratedTruth, ASmallBoardIsRefusedAndItSaysWhatToDo) {
  board.spacing_m = 0.017;
  settings.tolerance_share = camera::CalibrationSettings{}.tolerance_share;
  const auto small = exact_view(0.05);
  const auto found = camera::calibrate({&small, 1}, settings);
  CHECK_TRUE(found->too_poor.has_value());
  STRCMP_CONTAINS("which covers 6 % of the photograph", found->too_poor->c_str());
  board.spacing_m = 0.038;
  const auto large = exact_view(0.02);
  CHECK_FALSE(camera::calibrate({&large, 1}, settings)->too_poor.has_value());
}

TEST(CalibratedTruth, BoardsInTheCornersTellTheLensThatOneInTheMiddleDoesNot) {
  board.spacing_m = 0.02;
  place.turns_deg = {1.0, -2.0, 0.0};
  std::vector<camera::BoardView> views{exact_view(0.02)};
  settings.tolerance_share = 1e-5;
  const auto alone = camera::calibrate(views, settings);
  STRCMP_CONTAINS("the scale is uncertain by", alone->too_poor->c_str());
  for (const double x : {-0.12, 0.12}) {
    for (const double y : {-0.1, 0.1}) {
      place.aside_m = {x, y};
      views.push_back(exact_view(0.02));
    }
  }
  const auto all = camera::calibrate(views, settings);
  CHECK_TRUE(all->scale_errors.points < 0.3 * alone->scale_errors.points);
}

TEST(CalibratedTruth, APhotographGivenTwiceIsToldAndCountsOnce) {
  const auto once = exact_view(0.05);
  const auto found = camera::calibrate({&once, 1}, settings);
  auto copy = once;
  copy.name = "copy";
  const std::vector<camera::BoardView> twice{once, copy};
  const auto both = camera::calibrate(twice, settings);
  DOUBLES_EQUAL(found->scale_errors.points, both->scale_errors.points, 1e-12);
  const bool told = std::ranges::any_of(both->remarks, [](const std::string& remark) {
    return remark == "copy is the same photograph as board: it was left out";
  });
  CHECK_TRUE(told);
  const std::vector<camera::BoardView> again{once, exact_view(0.05)};
  LONGS_EQUAL(2 * 54, camera::calibrate(again, settings)->fit.points);
}
