// The numbers' derivatives by the images' times.
#include <cmath>
#include <string>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/reduced_frames.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

/// Smooth in the measurements: the same images in use, the same effects.
Readout of(const Frame& frame, bool by_time = false) {
  return *reduce(frame, Estimator::best,
                 {.effects = flight::Effects{}, .reject_outliers = false, .by_time = by_time});
}

Frame later(Frame frame, std::size_t image, double by_s) {
  frame.images[image].time_s += by_s;
  return frame;
}

/// How far the derivatives are off, over what the noise of the image's own place makes of the number: both by the time
/// in which the ball flies an sd of its place.
double largest_share_off(const Frame& frame) {
  constexpr double kStep_s = 1e-7;
  constexpr double kUnit_s = 0.5e-3 / 17.0;  // sd of the place over the speed
  const Readout readout = of(frame, true);
  LONGS_EQUAL(frame.images.size(), readout.by_time.size());
  double worst = 0.0;
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    const auto q = static_cast<Quantity>(k);
    if (!readout.value[q]) continue;
    for (std::size_t i = 0; i < frame.images.size(); ++i) {
      const double up = *of(later(frame, i, kStep_s)).value[q];
      const double down = *of(later(frame, i, -kStep_s)).value[q];
      const double slope = (up - down) / (2.0 * kStep_s);
      const double share = std::abs(slope - readout.by_time[i][k]) * kUnit_s / *readout.sd[q];
      worst = std::max(worst, share);
    }
  }
  return worst;
}

}  // namespace

TEST_GROUP(TimeResponse){};

TEST(TimeResponse, IsThatOfTheFrameAtOtherTimes) {
  for (const double noise : {0.01, 1.0}) {
    Setup setup;
    setup.noise_factor = noise;
    Frame frame = noisy(setup, 4);
    frame.temperature_c = 21.0;
    // Left out: products with residuals, which are hundredths of the way from image to image, and the lift's change.
    const double off = largest_share_off(frame);
    CHECK_TEXT(off < 0.01, std::to_string(off).c_str());
  }
}

TEST(TimeResponse, AllowsForCalibratedScaleAndErrorsInTime) {
  Frame frame = noisy(Setup{}, 6);
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 4.0;
  for (BallImage& image : frame.images) image.time_sd_s = 20e-6;
  const double off = largest_share_off(frame);
  CHECK_TEXT(off < 0.01, std::to_string(off).c_str());
}

TEST(TimeResponse, OfAShiftOfAllImagesIsNone) {
  Frame frame = noisy(Setup{}, 3);
  const Readout readout = of(frame, true);
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    double sum = 0.0, largest = 0.0;
    for (const TimeDerivatives& by_time : readout.by_time) {
      sum += by_time[k];
      largest = std::max(largest, std::abs(by_time[k]));
    }
    // The spin's decay and lift count from the leg's own middle, and move with it.
    CHECK_TEXT(std::abs(sum) <= 1e-3 * largest, std::string(kQuantityNames[k]).c_str());
  }
}

TEST(TimeResponse, IsGivenOnlyIfAskedFor) { CHECK_TRUE(of(noisy()).by_time.empty()); }
