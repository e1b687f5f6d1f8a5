// Whether a calibrated scale and the ball's diameters that contradict each other are told.
#include <random>
#include <string>

#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

/// Five images a leg, whose mean diameter is known to 0.77 % / sqrt(10) = 0.24 %.
Frame calibrated(double error, double relative_sd, std::uint64_t seed = 3) {
  Frame frame = noisy(vacuum(), seed);
  frame.px_per_m = 4000.0 * (1.0 + error);
  if (relative_sd > 0.0) frame.px_per_m_sd = 4000.0 * relative_sd;
  return frame;
}

bool contradicts(const Frame& frame) { return reduced(frame).flags.has(Flag::scale_contradicts_ball); }

}  // namespace

TEST_GROUP(CalibratedScale){};

TEST(CalibratedScale, ThatTheDiametersContradictTogetherIsTold) {
  // 3 % is 12 sd of the mean, but 4 of each image: none is an outlier.
  for (const double sd : {0.0, 0.002}) {
    for (const double error : {-0.03, 0.03}) {
      const Readout r = reduced(calibrated(error, sd));
      CHECK_TRUE(r.flags.has(Flag::scale_contradicts_ball));
      CHECK_FALSE(r.flags.has(Flag::outlier_image));
    }
    CHECK_FALSE(contradicts(calibrated(0.0, sd)));
  }
}

TEST(CalibratedScale, ThatDiametersOfUnknownNoiseContradictIsTold) {
  Frame frame = calibrated(0.03, 0.0);
  frame.diameter_sd_px.reset();
  CHECK_TRUE(contradicts(frame));
  frame.px_per_m = 4000.0;
  CHECK_FALSE(contradicts(frame));
}

TEST(CalibratedScale, IsNotContradictedByABallWithinItsTolerance) {
  Frame frame = calibrated(0.02, 0.002);
  CHECK_TRUE(contradicts(frame));
  frame.ball_diameter_sd_m = 0.02 * frame.ball_diameter_m;
  CHECK_FALSE(contradicts(frame));
  frame.px_per_m = 4000.0 * 1.10;  // five times the tolerance, though no diameter joins in the fit
  CHECK_TRUE(contradicts(frame));
}

TEST(CalibratedScale, CannotBeContradictedWhereThereIsNone) {
  Frame frame = noisy();
  frame.ball_diameter_m *= 1.05;
  CHECK_FALSE(contradicts(frame));
}

TEST(CalibratedScale, OneWrongDiameterIsAnOutlierAndNoContradiction) {
  Frame frame = calibrated(0.0, 0.0);
  frame.images[1].diameter_px += 40.0;
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::outlier_image));
  CHECK_FALSE(r.flags.has(Flag::scale_contradicts_ball));
}

TEST(CalibratedScale, OfCleanPhotographsOneInAThousandIsDoubted) {
  // 12 of 12,000, sd 3.5; within three sd.
  for (const bool stated : {true, false}) {
    const std::uint64_t seed = seed_or(22);
    test::Random random(seed);
    std::normal_distribution<double> error(0.0, 0.002);
    int doubted = 0;
    for (int i = 0; i < 12000; ++i) {
      Frame frame = test::photograph(Bounce{}, vacuum(), random);
      frame.px_per_m = 4000.0 * (1.0 + error(random));
      frame.px_per_m_sd = 8.0;
      if (!stated) frame.diameter_sd_px.reset();
      doubted += contradicts(frame);
    }
    CHECK_TRUE_TEXT(doubted >= 2 && doubted <= 22,
                    (std::to_string(doubted) + ", repeat with STROBE_SEED=" + std::to_string(seed)).c_str());
  }
}
