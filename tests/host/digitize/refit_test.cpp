// Outlines fitted once more with the size of the others: on a painted row of balls, all but one known.
#include <cmath>
#include <random>
#include <vector>

#include "host/digitize/outliers/selection.hpp"
#include "host/digitize/outline/outlines.hpp"
#include "host/digitize/refit.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;
namespace painter = strobe::testing;

constexpr double kBall_px = 80.0;
constexpr int kHeight = 160;
constexpr std::size_t kBalls = 5;

/// Images that do not overlap, and what an even background shows besides.
struct Row {
  Row() {
    std::mt19937_64 random(11);
    painting.width = 700;
    painting.height = kHeight;
    painting.bits = 16;
    painter::PaintedBall look = painter::random_ball(random, {}, kBall_px);
    look.fuzz_px = 0.0;
    for (std::size_t k = 0; k < kBalls; ++k)
      painting.balls.push_back(painter::next_image(look, {60.3 + 100.0 * static_cast<double>(k), 80.6}, 0.3));
    photograph = painter::paint(painting);
    settings.diameter_min_px = 0.85 * kBall_px;
    settings.diameter_max_px = 1.15 * kBall_px;
    std::vector<Candidate> candidates;
    for (const auto& ball : painting.balls)
      candidates.push_back({ball.centre + cv::Point2d(1.0, -1.0), 0.5 * kBall_px, 0.9});
    const FittedOutlines fitted = fit_outlines(photograph, map, candidates, settings);
    for (const auto& outline : fitted.outlines)
      outlines.push_back(outline.value());
    size = fit_size_model(outlines);
  }

  cv::Point2d place(std::size_t ball) const { return map.to_plane(painting.balls[ball].centre); }
  void refit() { refit_by_size(photograph, map, settings, size, outlines, unmeasured); }
  void leave_out(cv::Point2d at, Reason reason) {
    unmeasured.push_back({at, kBall_px, "image", {reason, ""}});
  }

  painter::Painting painting;
  Photograph photograph;
  PlaneMap map = PlaneMap::uncalibrated(kHeight);
  OutlineSettings settings;
  SizeModel size;
  std::vector<Outline> outlines;
  std::vector<Unmeasured> unmeasured;
};

/// A painted limb is known to a few hundredths of a px; ten times that is the same ball, and far from what it
/// was before.
constexpr double kSame_px = 0.3;

}  // namespace

TEST_GROUP(Refit){};

TEST(Refit, FindsABallThatWasLeftOutForWantOfPrecisionOrForItsSize) {
  for (const Reason reason : {Reason::imprecise, Reason::wrong_size}) {
    Row row;
    row.outlines.erase(row.outlines.begin() + 2);
    row.leave_out(row.place(2) + cv::Point2d(2.0, 1.0), reason);
    row.refit();
    CHECK_TRUE(row.unmeasured.empty());
    LONGS_EQUAL(kBalls, row.outlines.size());
    CHECK_TRUE(cv::norm(row.outlines.back().centre - row.place(2)) < kSame_px);
    DOUBLES_EQUAL(kBall_px, row.outlines.back().diameter, 2.0 * kSame_px);
  }
}

TEST(Refit, LeavesOutWhatIsNoBall) {
  Row row;
  // The even background; and a place that was left out for another reason.
  row.outlines.pop_back();
  row.leave_out({630.0, 80.0}, Reason::imprecise);
  row.leave_out(row.place(4), Reason::not_round);
  row.refit();
  LONGS_EQUAL(2, row.unmeasured.size());
  LONGS_EQUAL(kBalls - 1, row.outlines.size());
}

TEST(Refit, TellsNoBallTwice) {
  Row row;
  row.leave_out(row.place(1) + cv::Point2d(3.0, 0.0), Reason::imprecise);
  row.refit();
  LONGS_EQUAL(1, row.unmeasured.size());
  LONGS_EQUAL(kBalls, row.outlines.size());
}

TEST(Refit, MendsTheOneOutlineThatIsOfAnotherSize) {
  Row row;
  // It took something else for its limb, and is as uncertain as that makes it.
  row.outlines[3].centre.x += 4.0;
  row.outlines[3].diameter += 9.0;
  row.outlines[3].covariance = cv::Matx33d::eye();
  const cv::Point2d other = row.outlines[2].centre;
  row.refit();
  LONGS_EQUAL(kBalls, row.outlines.size());
  CHECK_TRUE(cv::norm(row.outlines[3].centre - row.place(3)) < kSame_px);
  DOUBLES_EQUAL(kBall_px, row.outlines[3].diameter, 2.0 * kSame_px);
  // Those that agree stay as they are.
  DOUBLES_EQUAL(0.0, cv::norm(row.outlines[2].centre - other), 0.0);
}

TEST(Refit, NeedsFourOutlinesToKnowTheirSize) {
  Row row;
  row.outlines.resize(3);
  row.leave_out(row.place(4), Reason::imprecise);
  row.refit();
  LONGS_EQUAL(1, row.unmeasured.size());
  LONGS_EQUAL(3, row.outlines.size());
}
