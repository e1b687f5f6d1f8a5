// What planned photographs of a board promise, against calibrations that have them.
#include "host/camera/board_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/host/camera/pinhole.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using camera::NearerSide;
using testing::Pinhole;

namespace {

const camera::BoardPattern kBoard{camera::BoardKind::chessboard, 9, 6, 0.02};
constexpr double kDistance_m = 1.0;

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_GROUP(BoardPlan) {
  Pinhole pinhole{640, 480, 1100.0, -0.05, 0.0, {319.5, 239.5}};
  std::mt19937_64 random{33};
  camera::CalibrationSettings settings{640, 480, 0.0, 0.0, kDistance_m, 0.001};

  camera::BoardView seen(const testing::Pose& pose) {
    return testing::view(pinhole, pose, kBoard, 0.05, random);
  }
  /// Over a tenth of the photograph, in its middle, and one slanted.
  std::vector<camera::BoardView> first_views() {
    return {seen(testing::pose(kBoard, kDistance_m, {0.01, -0.02, 0.0})),
            seen(testing::pose(kBoard, kDistance_m, {0.4, 0.0, 0.0}))};
  }
  /// As the true camera sees the board where the plan has it.
  testing::Pose pose_of(const camera::PlannedBoard& planned) const {
    const double z = kDistance_m * planned.placement.distance_share, slant = planned.placement.slant_rad;
    const cv::Point2d aside = (planned.middle_px - pinhole.centre) * (z / pinhole.focal_px);
    cv::Vec3d turns_rad;
    if (planned.placement.nearer == NearerSide::left) turns_rad[1] = -slant;
    if (planned.placement.nearer == NearerSide::right) turns_rad[1] = slant;
    if (planned.placement.nearer == NearerSide::upper) turns_rad[0] = slant;
    if (planned.placement.nearer == NearerSide::lower) turns_rad[0] = -slant;
    return testing::pose(kBoard, z, turns_rad, aside);
  }
};

TEST(BoardPlan, PromisesWhatACalibrationWithThePhotographStates) {
  const auto views = first_views();
  const auto before = camera::calibrate(views, settings);
  const auto ranked = camera::rank_placements(*before, kBoard, settings);
  for (const double at : {0.0, 0.3, 0.6, 1.0}) {
    const auto& planned = ranked[static_cast<std::size_t>(at * static_cast<double>(ranked.size() - 1))];
    auto more = views;
    more.push_back(seen(pose_of(planned)));
    const auto after = camera::calibrate(more, settings);
    // Both for the noise as estimated: what is left is the curvature of the fit, and the priors' weight, which goes with
    // the noise.
    const double ratio = (planned.scale_sd_share / before->fit.sigma_px) /
                         (after->scale_errors.points / after->fit.sigma_px);
    CHECK_TRUE_TEXT(std::abs(ratio - 1.0) < 0.05, fmt::format("{}: {}", describe(planned.placement), ratio).c_str());
  }
}

TEST(BoardPlan, TheOutlineIsWhereTheCameraSeesTheBoard) {
  pinhole.k1 = 0.0;
  const auto views = first_views();
  const auto found = camera::calibrate(views, settings);
  for (const camera::PlannedBoard& planned : camera::rank_placements(*found, kBoard, settings)) {
    const testing::Pose pose = pose_of(planned);
    const std::vector<cv::Point2d> corners{{-0.02, -0.02}, {0.18, -0.02}, {0.18, 0.12}, {-0.02, 0.12}};
    for (std::size_t i = 0; i < 4; ++i) {
      const cv::Point2d at = pinhole.project(pose.to_camera(corners[i]));
      // The lens by the fit bends up to a pixel or so at the corners; the focal length is known to a few per mille.
      CHECK_TRUE(cv::norm(at - planned.outline_px[i]) < 4.0);
      CHECK_TRUE(at.x > 0.0 && at.y > 0.0 && at.x < 639.0 && at.y < 479.0);
    }
    // The side that is nearer looks longer.
    const auto& o = planned.outline_px;
    const double left = cv::norm(o[3] - o[0]), right = cv::norm(o[2] - o[1]);
    const double upper = cv::norm(o[1] - o[0]), lower = cv::norm(o[2] - o[3]);
    CHECK_EQUAL(planned.placement.nearer == NearerSide::left, left > 1.02 * right);
    CHECK_EQUAL(planned.placement.nearer == NearerSide::right, right > 1.02 * left);
    CHECK_EQUAL(planned.placement.nearer == NearerSide::upper, upper > 1.02 * lower);
    CHECK_EQUAL(planned.placement.nearer == NearerSide::lower, lower > 1.02 * upper);
  }
}

TEST(BoardPlan, GoesAwayFromWhereTheBoardsWere) {
  const auto views = first_views();
  const auto found = camera::calibrate(views, settings);
  const camera::BoardPlan plan = camera::plan_boards(*found, kBoard, settings, 3);
  LONGS_EQUAL(3, plan.next.size());
  const auto& best = plan.next.front().placement;
  CHECK_TRUE_TEXT(best.across != 0 || best.down != 0, describe(best).c_str());
  double before = found->scale_errors.points;
  DOUBLES_EQUAL(before, plan.scale_sd_share, 0.0);
  for (const camera::PlannedBoard& board : plan.next) {
    CHECK_TRUE(board.scale_sd_share < before);
    CHECK_TRUE(board.scale_sd_share > plan.limit_share);
    before = board.scale_sd_share;
  }
  CHECK_TRUE(plan.distance_known);
  CHECK_TRUE(*plan.next_distance_sd_m <= 1.001 * *plan.distance_sd_m);  // searched for to a thousandth
}

TEST(BoardPlan, OfOneStraightPhotographAssumesALensAndSaysThatItWillBeKnown) {
  settings.lens_distance_m.reset();
  settings.lens_distance_sd_m.reset();
  const auto view = seen(testing::pose(kBoard, kDistance_m, {0.0, 0.0, 0.0}));
  const auto found = camera::calibrate({&view, 1}, settings);
  CHECK_FALSE(found->place.has_value());
  const camera::BoardPlan plan = camera::plan_boards(*found, kBoard, settings, 2);
  CHECK_FALSE(plan.distance_known);
  CHECK_FALSE(plan.distance_sd_m.has_value());
  CHECK_TRUE(plan.next_distance_sd_m.has_value());
}

TEST(BoardPlan, ABoardThatFillsTheViewGoesNowhere) {
  const camera::BoardPattern large{camera::BoardKind::chessboard, 9, 6, 0.1};
  const auto view = testing::view(pinhole, testing::pose(large, kDistance_m, {}), large, 0.05, random);
  const auto found = camera::calibrate({&view, 1}, settings);
  CHECK_TRUE(camera::plan_boards(*found, large, settings, 2).next.empty());
}

TEST(BoardPlan, IsDrawnWithinThePhotographsFrame) {
  const auto views = first_views();
  const auto found = camera::calibrate(views, settings);
  const camera::BoardPlan plan = camera::plan_boards(*found, kBoard, settings, 2);
  const std::string svg = plan_svg(plan, *found, kBoard, settings);
  STRCMP_CONTAINS("viewBox=\"0 0 720 540\"", svg.c_str());
  LONGS_EQUAL(4, count_of(svg, "<polygon "));  // with those so far
  STRCMP_CONTAINS(describe(plan.next[1].placement).c_str(), svg.c_str());
}

TEST(BoardPlan, PlacementsAreDescribedInWords) {
  STRCMP_EQUAL("slanted by 30 degrees, its left side nearer, in the upper right corner, 1.25 times as far as the "
               "balls' plane",
               camera::describe(camera::BoardPlacement{1, -1, 1.25, 0.5235987755982988, NearerSide::left}).c_str());
  STRCMP_EQUAL("slanted by 20 degrees, its lower side nearer, in the middle, as far as the balls' plane",
               camera::describe(camera::BoardPlacement{0, 0, 1.0, 0.3490658503988659, NearerSide::lower}).c_str());
}
