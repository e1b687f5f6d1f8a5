// A ball that bounces on along a painted photograph, from the photograph to the readout of each bounce.
#include <algorithm>
#include <cmath>
#include <random>

#include "common/flight/gravity.hpp"
#include "common/reduction/reduce.hpp"
#include "host/digitize/digitize.hpp"
#include "tests/host/digitize/painter.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
namespace painter = strobe::testing;
using digitize::DigitizeSettings;

constexpr double kDiameter_px = 60.0;
constexpr double kBall_m = 0.0651;
constexpr double kPx_per_m = kDiameter_px / kBall_m;
constexpr double kPeriod_s = 0.04;
constexpr int kHeight = 480;
constexpr double kPlateRow = 430.5;
constexpr double kGravity = flight::kStandardGravity_mps2;
constexpr double kRestitution = 0.85, kDwell_s = 4e-3, kVx_mps = 1.0, kDrop_m = 0.35;

double touchdown_mps(int bounce) {
  return std::sqrt(2.0 * kGravity * kDrop_m) * std::pow(kRestitution, bounce - 1);
}

/// Without friction and air: where the ball is in flight, seen from the surface; nullopt in contact.
std::optional<cv::Point2d> place(double time_s) {
  double start_s = 0.0, lasts_s = touchdown_mps(1) / kGravity, up_mps = 0.0, from_m = kDrop_m;
  for (int bounce = 1; time_s > start_s + lasts_s; ++bounce) {
    start_s += lasts_s + kDwell_s;
    if (time_s < start_s) return std::nullopt;
    up_mps = kRestitution * touchdown_mps(bounce);
    lasts_s = 2.0 * up_mps / kGravity;
    from_m = 0.0;
  }
  const double s = time_s - start_s;
  return cv::Point2d(kVx_mps * time_s, 0.5 * kBall_m + from_m + up_mps * s - 0.5 * kGravity * s * s);
}

/// Of three legs: two bounces.
digitize::Photograph picture() {
  std::mt19937_64 random(5);
  painter::Painting painting;
  painting.width = 1400;
  painting.height = kHeight;
  painting.bits = 16;
  painting.background = 0.04;
  painting.plate_row = kPlateRow;
  painting.plate = 0.5;
  painter::PaintedBall look = painter::random_ball(random, {}, kDiameter_px);
  look.light = 0.2;
  for (double t = 0.011; t < 1.2; t += kPeriod_s) {
    const auto at = place(t);
    if (!at) continue;
    look = painter::next_image(look, {60.0 + kPx_per_m * at->x, kPlateRow - kPx_per_m * at->y}, 0.1);
    look.floor_row = kPlateRow;
    painting.balls.push_back(look);
  }
  return painter::paint(painting);
}

DigitizeSettings settings(int bounce) {
  DigitizeSettings s;
  s.ball_diameter_m = kBall_m;
  s.px_per_m = 1.01 * kPx_per_m;
  s.bounce = bounce;
  std::vector<double> times;
  for (int k = 0; k < 40; ++k) times.push_back(kPeriod_s * k);
  s.flash_times_s = times;
  return s;
}

}  // namespace

TEST_GROUP(SeveralBounces){};

TEST(SeveralBounces, AreEachReducedByTheirOwnLegs) {
  const auto photograph = picture();
  for (const int bounce : {1, 2}) {
    auto result = digitize::digitize(photograph, settings(bounce));
    CHECK_TRUE(result.has_value());
    reduction::Frame frame = result->frame;
    CHECK_TRUE(std::ranges::any_of(frame.images, &reduction::BallImage::other_leg));
    std::erase_if(frame.images, [](const reduction::BallImage& image) { return image.other_leg; });
    frame.air_density_kgpm3 = 0.0;
    const auto readout = reduction::reduce(frame, reduction::Estimator::best);
    CHECK_TRUE(readout.has_value());
    using reduction::Quantity;
    const auto vy_td = readout->value[Quantity::vy_td_mps], vy_lo = readout->value[Quantity::vy_lo_mps],
               vx_td = readout->value[Quantity::vx_td_mps];
    CHECK_TRUE(vy_td && vy_lo && vx_td);
    // A tenth of a px over legs of seven images and more, 0.24 s, and the scale: well below half a per cent.
    DOUBLES_EQUAL(-touchdown_mps(bounce), *vy_td, 0.005 * touchdown_mps(bounce));
    DOUBLES_EQUAL(kRestitution * touchdown_mps(bounce), *vy_lo, 0.005 * touchdown_mps(bounce));
    DOUBLES_EQUAL(kVx_mps, *vx_td, 0.005);
  }
}
