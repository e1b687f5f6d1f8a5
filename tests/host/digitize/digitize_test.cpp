// The whole digitizer on small painted photographs: what comes out is held against what was painted.
#include "host/digitize/digitize.hpp"

#include <cmath>

#include "common/reduction/reduce.hpp"
#include "tests/host/digitize/painter.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
namespace painter = strobe::testing;
using digitize::DigitizeSettings;
using digitize::Effort;
using reduction::Leg;

constexpr double kDiameter_px = 96.0;
constexpr double kBall_m = 0.0651;
constexpr int kHeight = 420;
constexpr double kPlateRow = 360.5;

struct Placed {
  cv::Point2d centre;  // plane px
  Leg leg;
};

/// Five images down, one pressed flat, five up; to the right.
std::vector<Placed> bounce() {
  std::vector<Placed> images;
  const double surface = kHeight - 1 - kPlateRow;
  for (int k = 5; k >= 1; --k)
    images.push_back({{400.0 - 75.3 * k + 20.0, surface + 10.0 + 44.7 * k}, Leg::incoming});
  images.push_back({{408.0, surface + 39.0}, Leg::contact});
  for (int k = 1; k <= 5; ++k)
    images.push_back({{396.0 + 60.4 * k, surface + 32.0 + 35.2 * k}, Leg::rebound});
  return images;
}

painter::Painting picture(const std::vector<Placed>& images) {
  std::mt19937_64 random(11);
  painter::Painting painting;
  painting.width = 760;
  painting.height = kHeight;
  painting.bits = 16;
  painting.background = 0.04;
  painting.plate_row = kPlateRow;
  painting.plate = 0.5;
  painting.seed = 4;
  painter::PaintedBall look = painter::random_ball(random, {}, kDiameter_px);
  look.light = 0.2;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const cv::Point2d at(images[i].centre.x, kHeight - 1 - images[i].centre.y);
    look = painter::next_image(look, at, 0.13);
    look.floor_row = kPlateRow;
    painting.balls.push_back(look);
  }
  return painting;
}

DigitizeSettings settings() {
  DigitizeSettings s;
  s.ball_diameter_m = kBall_m;
  s.px_per_m = 1.02 * kDiameter_px / kBall_m;  // known to some per cent
  return s;
}

}  // namespace

TEST_GROUP(Digitize){};

TEST(Digitize, FindsAllImagesOfABounceInOrderWithTheSurface) {
  const auto placed = bounce();
  const auto photograph = painter::paint(picture(placed));
  DigitizeSettings s = settings();
  std::vector<double> times;
  for (int k = 0; k < 30; ++k) times.push_back(3e-3 * k);
  s.flash_times_s = times;
  const auto result = digitize::digitize(photograph, s);
  CHECK_TRUE(result.has_value());
  const auto& frame = result->frame;
  LONGS_EQUAL(placed.size(), frame.images.size());
  for (std::size_t i = 0; i < placed.size(); ++i) {
    CHECK_TRUE(frame.images[i].leg == placed[i].leg);
    // Half a per cent of the diameter: far below the distance of images, far above the fit's error.
    DOUBLES_EQUAL(placed[i].centre.x, frame.images[i].centre_px.x, 0.5);
    DOUBLES_EQUAL(placed[i].centre.y, frame.images[i].centre_px.y, 0.5);
    DOUBLES_EQUAL(kDiameter_px, frame.images[i].diameter_px, 1.0);
    CHECK_TRUE(frame.images[i].centre_cov_px2.has_value());
    STRCMP_EQUAL("auto", frame.images[i].source.c_str());
    if (i > 0) DOUBLES_EQUAL(3e-3, frame.images[i].time_s - frame.images[i - 1].time_s, 1e-9);
  }
  LONGS_EQUAL(result->outlines.size(), frame.images.size());
  CHECK_TRUE(frame.images[5].top_px.has_value());
  CHECK_TRUE(frame.surface_px.size() >= 2);
  const double surface = kHeight - 1 - kPlateRow;
  for (const auto& p : frame.surface_px) DOUBLES_EQUAL(surface, p.y, 0.1);
}

TEST(Digitize, GivesAFrameThatCanBeReduced) {
  DigitizeSettings s = settings();
  std::vector<double> times;
  for (int k = 0; k < 30; ++k) times.push_back(3e-3 * k);
  s.flash_times_s = times;
  const auto result = digitize::digitize(painter::paint(picture(bounce())), s);
  CHECK_TRUE(result.has_value());
  const auto readout = reduction::reduce(result->frame, reduction::Estimator::best);
  CHECK_TRUE(readout.has_value());
  // 75.3 px of 96 px a ball of 65.1 mm in 3 ms.
  DOUBLES_EQUAL(75.3 / kDiameter_px * kBall_m / 3e-3, *readout->value[reduction::Quantity::vx_td_mps], 0.2);
}

TEST(Digitize, WithoutFlashTimesMakesNoneUp) {
  const auto result = digitize::digitize(painter::paint(picture(bounce())), settings());
  CHECK_TRUE(result.has_value());
  for (const auto& image : result->frame.images) {
    CHECK_TRUE(std::isnan(image.time_s));
    CHECK_FALSE(image.flash_index.has_value());
  }
}

TEST(Digitize, OfAnEmptyPlateIsAResultWithoutImages) {
  const auto result = digitize::digitize(painter::paint(picture({})), settings());
  CHECK_TRUE(result.has_value());
  LONGS_EQUAL(0, result->frame.images.size());
}

TEST(Digitize, RefusesSettingsOutOfRangeByName) {
  const auto photograph = painter::paint(picture({}));
  DigitizeSettings s = settings();
  s.px_per_m = std::nan("");
  STRCMP_CONTAINS("px_per_m", digitize::digitize(photograph, s).error().message.c_str());
  s = settings();
  s.flash_times_s = std::vector<double>{0.0, 0.0};
  STRCMP_CONTAINS("flash_times_s[1]", digitize::digitize(photograph, s).error().message.c_str());
}

TEST(Digitize, IsTheSameForAnyNumberOfThreads) {
  const auto photograph = painter::paint(picture(bounce()));
  DigitizeSettings s = settings();
  s.effort = Effort::fast;
  const auto several = digitize::digitize(photograph, s);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const auto one = digitize::digitize(photograph, s);
  cv::setNumThreads(threads);
  LONGS_EQUAL(several->frame.images.size(), one->frame.images.size());
  for (std::size_t i = 0; i < one->frame.images.size(); ++i) {
    CHECK_TRUE(one->frame.images[i].centre_px.x == several->frame.images[i].centre_px.x);
    CHECK_TRUE(one->frame.images[i].diameter_px == several->frame.images[i].diameter_px);
    CHECK_TRUE(one->frame.images[i].equator_rad == several->frame.images[i].equator_rad);
  }
}
