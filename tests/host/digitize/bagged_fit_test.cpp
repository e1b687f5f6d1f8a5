#include "host/digitize/outline/bagged_fit.hpp"

#include <cmath>

#include "host/digitize/outline/outlines.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::digitize;
using namespace strobe::testing;

namespace {

constexpr double kCut_px = 120.0;

/// Two images of a ball with a look of its own; where they overlap the sensor is at its end.
Painting bright_pair(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Painting painting;
  painting.width = 270;
  painting.height = 180;
  painting.blur_px = 0.8 + 0.5 * unit(random);
  painting.seed = seed;
  auto ball = random_ball(random, {85 + unit(random), 85 + unit(random)}, kCut_px);
  ball.light = 0.45;
  for (int i = 0; i < 2; ++i)
    painting.balls.push_back(next_image(ball, ball.centre + cv::Point2d(70 * i, 10 * i), 0.5 * i));
  return painting;
}

OutlineShape start_of(const LocalFrame& frame, const PlaneMap& map, cv::Point2d centre_image) {
  OutlineShape shape;
  shape.centre = frame.from_plane(map.to_plane(centre_image)) + cv::Point2d(0.4, -0.3);
  shape.radius = 0.5 * kCut_px + 0.3;
  return shape;
}

}  // namespace

TEST_GROUP(OutlineCuts){};

TEST(OutlineCuts, MeasureOverexposedPairsTruly) {
  double error2 = 0.0, normalized2 = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Painting painting = bright_pair(seed);
    const PlaneMap map = PlaneMap::uncalibrated(painting.height);
    std::vector<Candidate> candidates;
    for (const auto& ball : painting.balls)
      candidates.push_back({ball.centre + cv::Point2d(0.8, -0.7), kCut_px / 2 + 1, 0.8});
    OutlineSettings settings;
    settings.diameter_min_px = 0.92 * kCut_px;
    settings.diameter_max_px = 1.08 * kCut_px;
    settings.effort = Effort::thorough;
    const auto outlines = fit_outlines(paint(painting), map, candidates, settings);
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      CHECK_TRUE(outlines[i].has_value());
      const cv::Point2d off = outlines[i]->centre - map.to_plane(painting.balls[i].centre);
      const cv::Vec3d error(off.x, off.y, outlines[i]->diameter - kCut_px);
      error2 += off.dot(off) / 2;
      normalized2 += error.dot(outlines[i]->covariance.inv() * error) / 3;
      ++count;
    }
  }
  LONGS_EQUAL(12, count);
  CHECK(std::sqrt(error2 / count) < 0.15);
  // 36 squares, of pairs that look alike: as if of 18. Their mean's sd is then sqrt(2 / 18) = 0.33; three of
  // them above. Below there is no bound worth the name: what the cuts disagree by is counted in full.
  CHECK(normalized2 / count < 2.0);
}

TEST(OutlineCuts, CountHowFarTheyDisagree) {
  const Painting painting = bright_pair(3);
  const auto photograph = paint(painting);
  const PlaneMap map = PlaneMap::uncalibrated(painting.height);
  const cv::Point2d centre = painting.balls[0].centre;
  const LocalFrame frame(map, centre, kCut_px);
  const OutlineShape start = start_of(frame, map, centre);
  const std::vector<OutlineShape> others{start_of(frame, map, painting.balls[1].centre)};
  const OutlineFitSettings settings;
  const auto once = fit_outline(photograph, frame, start, 1.2, others, settings);
  const auto cuts = fit_outline_bagged(photograph, frame, start, 1.2, others, settings);
  CHECK_TRUE(once.has_value() && cuts.has_value());
  // One of the cuts' results, and their middle, differ by some of what the covariance holds.
  for (int a = 0; a < 3; ++a) CHECK(cuts->covariance(a, a) > 0.0);
  CHECK(cv::norm(cuts->shape.centre - once->shape.centre) <
        4.0 * std::sqrt(cuts->covariance(0, 0) + cuts->covariance(1, 1)));
}

TEST(OutlineCuts, FindNothingWhereThereIsNoEdge) {
  Painting painting = bright_pair(1);
  painting.balls.clear();
  const PlaneMap map = PlaneMap::uncalibrated(painting.height);
  const cv::Point2d centre(120.0, 90.0);
  const LocalFrame frame(map, centre, kCut_px);
  CHECK_FALSE(fit_outline_bagged(paint(painting), frame, start_of(frame, map, centre), 1.2, {}, {}));
}
