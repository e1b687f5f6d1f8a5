#include <cmath>
#include <random>
#include <vector>

#include "host/digitize/outline/outline_sd.hpp"
#include "host/digitize/outline/outlines.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::digitize;
using namespace strobe::testing;

namespace {

constexpr int kSectors = 100;
constexpr double kRadius_px = 130.0, kRounding = 1.0 / (255.0 * 3.4641);

/// An outline fitted to offsets of its sectors, all seen equally well.
struct Drawn {
  SectorOffsets offsets;
  std::vector<OutlineVector> gradients;
  std::vector<double> residuals;
  OutlineVector found;

  Drawn(const std::vector<double>& off, double sd_px, double light) {
    offsets.edges.resize(kSectors);
    for (SectorEdge& edge : offsets.edges) edge.step = light;
    offsets.weight.assign(kSectors, 1.0 / (sd_px * sd_px));
    offsets.robust.assign(kSectors, 1.0);
    offsets.sensitivity = offsets.weight;
    offsets.common_sd.assign(kSectors, 0.0);
    OutlineMatrix normal = OutlineMatrix::zeros();
    OutlineVector right;
    for (int i = 0; i < kSectors; ++i) {
      const double a = 2.0 * CV_PI * i / kSectors;
      gradients.emplace_back(std::cos(a), std::sin(a), 1.0, std::cos(2.0 * a), std::sin(2.0 * a));
      normal += gradients.back() * gradients.back().t();
      right += off[static_cast<std::size_t>(i)] * gradients.back();
    }
    found = normal.inv() * right;
    for (int i = 0; i < kSectors; ++i)
      residuals.push_back(off[static_cast<std::size_t>(i)] - gradients[static_cast<std::size_t>(i)].dot(found));
  }

  OutlineSd sd(double sigma_px = 1.0, double depth_px = 9.0) const {
    return outline_covariance({offsets, gradients, residuals, sigma_px, kRadius_px, depth_px},
                              OutlineMatrix::eye() * 1e-6, kRounding);
  }
};

/// Around the circle, neighbours correlated by `correlation`, those farther apart by its powers.
std::vector<double> correlated(std::mt19937_64& random, double sd_px, double correlation) {
  constexpr int kRunIn = 50;
  std::normal_distribution<double> normal;
  std::vector<double> off;
  double last = 0.0;
  for (int i = -kRunIn; i < kSectors; ++i) {
    last = correlation * last + sd_px * std::sqrt(1.0 - correlation * correlation) * normal(random);
    if (i >= 0) off.push_back(last);
  }
  return off;
}

Painting one_ball(std::mt19937_64& random, double diameter_px) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Painting painting;
  painting.width = painting.height = 160;
  painting.background = 0.02 + 0.06 * unit(random);
  painting.seed = random();
  const auto ball = random_ball(random, {80.0 + unit(random), 80.0 + unit(random)}, diameter_px);
  painting.balls.push_back(ball);
  return painting;
}

/// Of the first ball's light.
Outline outline_of(const Painting& painting) {
  const PaintedBall& ball = painting.balls[0];
  const Candidate candidate{ball.centre + cv::Point2d(0.6, -0.4), 0.5 * ball.diameter_px, 0.9};
  OutlineSettings settings;
  settings.diameter_min_px = 0.9 * ball.diameter_px;
  settings.diameter_max_px = 1.1 * ball.diameter_px;
  const auto outlines =
      fit_outlines(paint(painting), PlaneMap::uncalibrated(painting.height), {&candidate, 1}, settings).outlines;
  CHECK_TRUE(outlines[0].has_value());
  return *outlines[0];
}

double diameter_error_over_sd(const Painting& painting) {
  const Outline outline = outline_of(painting);
  return (outline.diameter - painting.balls[0].diameter_px) / std::sqrt(outline.covariance(2, 2));
}

}  // namespace

TEST_GROUP(OutlineSd){};

TEST(OutlineSd, IsTrueOfNoiseThatIsCorrelatedAlongTheOutline) {
  constexpr int kOutlines = 300;
  constexpr double kSd_px = 0.5;
  for (const double correlation : {0.0, 0.3, 0.5}) {
    std::mt19937_64 random(11);
    double errors = 0.0, stated = 0.0;
    for (int k = 0; k < kOutlines; ++k) {
      const Drawn drawn(correlated(random, kSd_px, correlation), kSd_px, 1e3);
      const OutlineSd sd = drawn.sd();
      // Without what all outlines are off alike, of which nothing was drawn.
      const double alike = sd.shared_radius_px * sd.shared_radius_px;
      errors += drawn.found[0] * drawn.found[0] + drawn.found[1] * drawn.found[1] + drawn.found[2] * drawn.found[2];
      stated += sd.covariance(0, 0) + sd.covariance(1, 1) + sd.covariance(2, 2) - alike;
    }
    // 900 squares tell the rms to 1/sqrt(1800) = 2.4 %, three of them 7 %; what a clamped correlation of a hundred
    // sectors, known to a tenth, adds is some per cent more.
    DOUBLES_EQUAL(1.0, std::sqrt(errors / stated), 0.07 + 0.08);
  }
}

// Every ball of another size, look and place, so that what a photograph's outlines share differs, too. Of
// `count` independent errors the rms over sds is known to 1/sqrt(2·count); the bounds are three of that about
// one.
TEST(OutlineSd, IsTrueOfBallsSoDarkThatRoundingMovesThem) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double squares = 0.0;
  constexpr int kBalls = 20;
  for (int k = 0; k < kBalls; ++k) {
    Painting painting = one_ball(random, 100.0 + unit(random));
    painting.balls[0].light = 0.03;  // eight of 255 numbers, and no noise to spread them
    painting.balls[0].grain = 0.0;
    painting.electrons = painting.read_noise = 0.0;
    squares += std::pow(diameter_error_over_sd(painting), 2) / kBalls;
  }
  CHECK_COMPARE(std::sqrt(squares), >, 0.5);
  CHECK_COMPARE(std::sqrt(squares), <, 1.5);
}

TEST(OutlineSd, IsTrueOfSmallBallsSampledToAThirdOfTheirRadius) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double squares = 0.0;
  constexpr int kBalls = 20;
  for (int k = 0; k < kBalls; ++k) {
    Painting painting = one_ball(random, 36.0 + 8.0 * unit(random));
    painting.bits = 16;
    squares += std::pow(diameter_error_over_sd(painting), 2) / kBalls;
  }
  CHECK_COMPARE(std::sqrt(squares), >, 0.5);
  CHECK_COMPARE(std::sqrt(squares), <, 1.5);
}

TEST(OutlineSd, IsTrueOfBallsThatTwoUnequalFlashesShowAPixelOrTwoApart) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double squares = 0.0, without = 0.0;
  constexpr int kBalls = 20;
  for (int k = 0; k < kBalls; ++k) {
    Painting painting = one_ball(random, 120.0);
    const double before = outline_of(painting).covariance(0, 0);
    const double share = 0.05 + 0.15 * unit(random), apart_px = 1.0 + unit(random);
    const double true_x = painting.balls[0].centre.x + share * apart_px;
    painting.balls.push_back(painting.balls[0]);
    painting.balls[0].light *= 1.0 - share;
    painting.balls[1].light *= share;
    painting.balls[1].centre.x += apart_px;
    const Outline outline = outline_of(painting);
    squares += std::pow(outline.centre.x - true_x, 2) / outline.covariance(0, 0) / kBalls;
    without += std::pow(outline.centre.x - true_x, 2) / before / kBalls;
  }
  CHECK_COMPARE(std::sqrt(squares), >, 0.5);
  CHECK_COMPARE(std::sqrt(squares), <, 1.5);
  CHECK_COMPARE(std::sqrt(squares), <, 0.8 * std::sqrt(without));
}

TEST(OutlineSd, CountsATerminatorForWhatAllBallsOfThePhotographAreOffAlike) {
  const std::vector<double> none(kSectors, 0.0);
  Drawn drawn(none, 0.1, 0.4);
  const OutlineSd lit = drawn.sd();
  // Beside a shadow that hides a third of the outline.
  for (int i = 0; i < kSectors; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (i < 33) drawn.offsets.weight[at] = drawn.offsets.sensitivity[at] = 0.0;
    if ((i >= 33 && i < 38) || i >= 95) drawn.offsets.common_sd[at] = 0.5;
  }
  const OutlineSd half = drawn.sd();
  CHECK_COMPARE(half.shared_radius_px, >, 5.0 * lit.shared_radius_px);
  CHECK_COMPARE(half.covariance(2, 2), >=, half.shared_radius_px * half.shared_radius_px);
}
