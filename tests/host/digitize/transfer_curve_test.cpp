// Whether numbers are proportional to light, told from overlaps alone.
#include "host/digitize/transfer/transfer_curve.hpp"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "host/digitize/digitize.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
namespace painter = strobe::testing;

namespace {

constexpr double kDiameter_px = 90.0;

painter::Painting row_of_balls(std::uint64_t seed, double apart_px, int count) {
  std::mt19937_64 random(seed);
  painter::Painting painting;
  painting.width = static_cast<int>(apart_px * count) + 100;
  painting.height = 200;
  painting.bits = 16;
  painting.seed = seed;
  painter::PaintedBall look = painter::random_ball(random, {80.0, 80.0}, kDiameter_px);
  look.light = 0.25;
  for (int i = 0; i < count; ++i) {
    look = painter::next_image(look, {80.3 + apart_px * i, 80.0 + 4.7 * i}, 0.2);
    painting.balls.push_back(look);
  }
  return painting;
}

/// As a file of that exponent has it.
digitize::Photograph with_exponent(const painter::Painting& painting, double exponent) {
  digitize::Photograph photograph = painter::paint(painting);
  cv::pow(cv::max(photograph.intensity, 0.0), exponent, photograph.intensity);
  return photograph;
}

std::vector<digitize::Outline> outlines_of(const painter::Painting& painting) {
  std::vector<digitize::Outline> outlines;
  for (const painter::PaintedBall& ball : painting.balls) {
    digitize::Outline o;
    o.centre = {ball.centre.x, painting.height - 1.0 - ball.centre.y};
    o.diameter = ball.diameter_px;
    o.blur_px = painting.blur_px;
    outlines.push_back(o);
  }
  return outlines;
}

std::optional<digitize::TransferCurve> measured(const painter::Painting& painting, double exponent) {
  return digitize::measure_transfer(with_exponent(painting, exponent),
                                    digitize::PlaneMap::uncalibrated(painting.height), outlines_of(painting));
}

}  // namespace

TEST_GROUP(TransferCurve){};

TEST(TransferCurve, IsFoundWhereLightAddsUp) {
  // Of sixteen normalized errors, eight of them free, the rms is below 1 + 3 / sqrt(16).
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const double exponent : {1.0, 0.45}) {
      const auto curve = measured(row_of_balls(seed, 62.0, 8), exponent);
      CHECK_TRUE(curve.has_value());
      sum += std::pow((curve->exponent - exponent) / curve->sd, 2.0) / 16.0;
      CHECK_EQUAL(exponent == 1.0, curve->is_proportional());
    }
  }
  const double rms = std::sqrt(sum);
  CHECK_TRUE_TEXT(rms < 1.75, fmt::format("normalized errors' rms {}", rms).c_str());
}

TEST(TransferCurve, CannotBeToldWithoutOverlaps) {
  CHECK_FALSE(measured(row_of_balls(1, 100.0, 8), 0.45).has_value());
  CHECK_FALSE(measured(row_of_balls(1, 62.0, 3), 0.45).has_value());  // four crossings
}

TEST(TransferCurve, OfAScreenWidensNoBallOnceItIsUndone) {
  const auto painting = row_of_balls(3, 62.0, 8);
  digitize::DigitizeSettings settings;
  settings.px_per_m = kDiameter_px / settings.ball_diameter_m;
  const auto plain = digitize::digitize(with_exponent(painting, 1.0), settings);
  const auto screen = digitize::digitize(with_exponent(painting, 0.45), settings);
  LONGS_EQUAL(8, plain->frame.images.size());
  LONGS_EQUAL(8, screen->frame.images.size());
  CHECK_TRUE(plain->transfer->is_proportional());
  CHECK_FALSE(screen->transfer->is_proportional());
  STRCMP_CONTAINS("not proportional to light", screen->remarks.back().c_str());
  for (std::size_t i = 0; i < 8; ++i) {
    const auto& image = screen->frame.images[i];
    // Without it half a pixel more, ten sd.
    DOUBLES_EQUAL(plain->frame.images[i].diameter_px, image.diameter_px, 3.0 * *image.diameter_sd_px);
  }
}

TEST(TransferCurve, ThatAFileOf8BitsCannotTellIsSaid) {
  auto painting = row_of_balls(2, 100.0, 6);
  painting.bits = 8;
  digitize::DigitizeSettings settings;
  settings.px_per_m = kDiameter_px / settings.ball_diameter_m;
  const auto found = digitize::digitize(painter::paint(painting), settings);
  CHECK_FALSE(found->frame.images.empty());
  STRCMP_CONTAINS("whether the file's numbers are proportional to light cannot be told",
                  found->remarks.back().c_str());
}

TEST(TransferCurve, LeavesThePhotographThatItLinearizesAsItIs) {
  digitize::Photograph photograph;
  photograph.intensity = cv::Mat(16, 16, CV_32F, cv::Scalar(0.25));
  const digitize::Photograph light = digitize::linearized(photograph, {0.5, 0.01, 9});
  DOUBLES_EQUAL(0.25, static_cast<double>(photograph.intensity.at<float>(3, 4)), 0.0);
  DOUBLES_EQUAL(0.0625, static_cast<double>(light.intensity.at<float>(3, 4)), 1e-7);  // rounding
}
