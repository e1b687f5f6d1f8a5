// One thing that a photograph was said to have been taken with is wrong: whether it is named, and nothing
// else. Drops with long legs, in which gravity and air tell.
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>

#include "tests/common/reduction/reduced_frames.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

constexpr int kShots = testing::repetitions(100);

/// A fifth of a pixel at 4000 px/m, as of a digitizer, on legs of a tenth of a second.
Setup long_legs() {
  Setup setup;
  setup.period_s = 10e-3;
  setup.incoming = setup.rebound = 10;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = 0.05e-3;
  setup.equator_sd_rad = 0.005;
  return setup;
}

Bounce drop() {
  Bounce drop;
  drop.vx_td = 0.3, drop.vy_td = -6.9, drop.omega_td = 5.0;
  drop.vx_lo = 0.2, drop.vy_lo = 5.3, drop.omega_lo = -4.0, drop.dwell_x_m = 0.001;
  return drop;
}

void calibrate(Frame& frame, double off_percent = 0.0) {
  frame.px_per_m = 4000.0 * (1.0 + 1e-2 * off_percent);
  frame.px_per_m_sd = 4.0;
}

struct Named {
  std::map<std::string, int> times;  ///< by cause, "none"
  double mean = 0.0, within_3_sd = 0.0;
  int flagged = 0;
};

Named named_in(const Setup& setup, const std::function<void(Frame&)>& spoil, double expected, Random& random) {
  Named named;
  for (int i = 0; i < kShots; ++i) {
    Frame frame = photograph(drop(), setup, random);
    calibrate(frame);
    spoil(frame);
    const Readout readout = reduced_in_air(frame);
    const bool flagged = readout.flags.has(Flag::outlier_image) ||
                         readout.flags.has(Flag::residuals_exceed_noise) ||
                         readout.flags.has(Flag::scale_contradicts_ball);
    named.flagged += flagged ? 1 : 0;
    CHECK_TRUE(flagged || !readout.likely_cause);
    ++named.times[readout.likely_cause ? std::string(name(readout.likely_cause->cause)) : "none"];
    if (!readout.likely_cause) continue;
    const LikelyCause& cause = *readout.likely_cause;
    if (std::abs(cause.value - expected) < 3.0 * cause.sd) named.within_3_sd += 1.0;
  }
  std::printf("flagged %d:", named.flagged);
  for (const auto& [cause, times] : named.times) std::printf(" %s %d", cause.c_str(), times);
  std::printf(" (%g within 3 sd); ", named.within_3_sd);
  return named;
}

/// Nothing but this cause is named, in most of the shots, and its size is right.
void check_only(const Named& named, const std::string& cause) {
  for (const auto& [other, times] : named.times)
    CHECK_TRUE_TEXT(other == cause || other == "none", other.c_str());
  const auto found = named.times.find(cause);
  CHECK_TRUE_TEXT(found != named.times.end() && found->second >= 0.8 * kShots, cause.c_str());
  // Of 100 more than 3 are beyond 3 sd once in five hundred runs.
  CHECK_TRUE(named.within_3_sd >= found->second - 3.0);
}

const auto kNothing = [](Frame&) {};

}  // namespace

TEST_GROUP(LikelyCause) {
  const std::uint64_t seed = seed_or(20261128);
  Random random{seed};
};

TEST(LikelyCause, IsTheAirWhereThereIsNone) {
  Setup setup = long_legs();
  setup.air.drag_coefficient = 0.0;
  setup.air.lift = false;
  check_only(named_in(setup, kNothing, 0.0, random), "air");
}

TEST(LikelyCause, IsTheAirWhereItDragsTwice) {
  Setup setup = long_legs();
  setup.air.drag_coefficient = 1.1;
  check_only(named_in(setup, kNothing, 2.0, random), "air");
}

TEST(LikelyCause, IsTheScaleWhereGravityAgreesWithTheBall) {
  check_only(named_in(long_legs(), [](Frame& frame) { calibrate(frame, 2.0); }, 100.0 * (1.0 / 1.02 - 1.0), random),
             "scale");
}

TEST(LikelyCause, IsTheBallWhereGravityAgreesWithTheScale) {
  check_only(named_in(long_legs(), [](Frame& frame) { frame.ball_diameter_m *= 1.02; },
                      100.0 * (1.0 / 1.02 - 1.0), random),
             "ball_diameter");
}

TEST(LikelyCause, IsTheClockWhereScaleAndBallAgree) {
  check_only(named_in(
                 long_legs(),
                 [](Frame& frame) {
                   for (BallImage& image : frame.images) image.time_s *= 1.02;
                 },
                 100.0 * (1.0 / 1.02 - 1.0), random),
             "flash_period");
}

TEST(LikelyCause, IsTheInclinationThatWasNotEntered) {
  Setup setup = long_legs();
  setup.incline_rad = 2.0 * std::numbers::pi / 180.0;
  check_only(named_in(setup, [](Frame& frame) { frame.surface_angle_deg = 0.0; }, 2.0, random), "inclination");
}

TEST(LikelyCause, IsNotNamedWhereNothingIsWrong) {
  // One clean photograph in some three hundred is flagged, and chance passes the rest once in 10,000.
  const Named named = named_in(long_legs(), kNothing, 0.0, random);
  CHECK_EQUAL(kShots, named.times.at("none"));
}

TEST(LikelyCause, IsNotNamedForABadImageNorForMoreNoiseThanStated) {
  const Named bad_image = named_in(
      long_legs(), [](Frame& frame) { frame.images[2].centre_px.y += 4.0; }, 0.0, random);
  CHECK_EQUAL(kShots, bad_image.flagged);
  CHECK_EQUAL(kShots, bad_image.times.at("none"));
  Setup noisy = long_legs();
  noisy.noise_factor = 3.0;
  const Named noise = named_in(noisy, kNothing, 0.0, random);
  CHECK_EQUAL(kShots, noise.flagged);
  CHECK_EQUAL(kShots, noise.times.at("none"));
}

TEST(LikelyCause, IsLeftOpenWhereTwoWouldDo) {
  // Without a calibration the ball is the scale: a larger ball and a slower clock bend paths alike.
  const Named named = named_in(
      long_legs(),
      [](Frame& frame) {
        frame.px_per_m.reset();
        frame.px_per_m_sd.reset();
        for (BallImage& image : frame.images) image.time_s *= 1.02;
      },
      0.0, random);
  CHECK_EQUAL(kShots, named.flagged);
  CHECK_EQUAL(kShots, named.times.at("none"));
}
