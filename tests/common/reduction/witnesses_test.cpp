// What one photograph says of gravity, scale, surface and the straightness of paths, against how it was made.
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "common/reduction/witnesses.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

constexpr int kShots = testing::repetitions(200);

/// A dropped ball on legs of a tenth of a second, a fifth of a pixel at 4000 px/m.
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

using Told = std::function<std::optional<Estimate>(const PhotographWitnesses&)>;

struct Scores {
  double mean = 0.0;         ///< of value less truth over sd
  double mean_square = 0.0;  //
};

Scores scores(const Setup& setup, const std::function<void(Frame&)>& spoil, const Told& told, double truth,
              Random& random) {
  Scores s;
  for (int i = 0; i < kShots; ++i) {
    Frame frame = photograph(drop(), setup, random);
    frame.px_per_m = 4000.0;
    frame.px_per_m_sd = 4.0;
    spoil(frame);
    const auto witnesses = photograph_witnesses(frame);
    CHECK_TRUE(witnesses && told(*witnesses));
    const Estimate estimate = *told(*witnesses);
    const double score = (estimate.value - truth) / estimate.sd;
    s.mean += score / kShots;
    s.mean_square += score * score / kShots;
  }
  std::printf("mean score %.3f, mean square %.3f; ", s.mean, s.mean_square);
  return s;
}

/// A mean of n scores has an sd of 1/sqrt(n), their mean square one of sqrt(2/n): four of them.
void check_honest(const Scores& s, double least_square = 1.0) {
  DOUBLES_EQUAL(0.0, s.mean, 4.0 / std::sqrt(kShots));
  CHECK_TRUE(s.mean_square < 1.0 + 4.0 * std::sqrt(2.0 / kShots));
  CHECK_TRUE(s.mean_square > least_square - 4.0 * std::sqrt(2.0 / kShots));
}

const auto kNothing = [](Frame&) {};
std::optional<Estimate> gravity(const PhotographWitnesses& w) { return w.gravity_mps2; }
std::optional<Estimate> scale(const PhotographWitnesses& w) { return w.diameters_px_per_m; }
std::optional<Estimate> surface(const PhotographWitnesses& w) { return w.surface_rad; }
std::optional<Estimate> paths(const PhotographWitnesses& w) { return w.path_residuals; }

}  // namespace

TEST_GROUP(Witnesses) {
  const std::uint64_t seed = seed_or(20261201);
  Random random{seed};
};

// Its sd holds what drag is known to, whose error is not drawn here: down to a half of the square.
TEST(Witnesses, GravityIsTheOneThatTheBallFellBy) {
  Setup moon = long_legs();
  moon.gravity_mps2 = 9.2;
  check_honest(scores(moon, kNothing, gravity, 9.2, random), 0.5);
}

TEST(Witnesses, GravityGrowsWithTheScaleAndFallsWithTheSquareOfTheClock) {
  check_honest(scores(
                   long_legs(), [](Frame& frame) { *frame.px_per_m /= 1.02; }, gravity, 1.02 * 9.80665, random),
               0.5);
  check_honest(scores(
                   long_legs(),
                   [](Frame& frame) {
                     for (BallImage& image : frame.images) image.time_s *= 1.02;
                   },
                   gravity, 9.80665 / (1.02 * 1.02), random),
               0.5);
}

TEST(Witnesses, GravityOnACalibratedScaleDoesNotHeedTheBall) {
  check_honest(scores(
                   long_legs(), [](Frame& frame) { frame.ball_diameter_m *= 1.02; }, gravity, 9.80665, random),
               0.5);
}

TEST(Witnesses, DiametersTellTheScaleWhateverTheCalibrationSays) {
  check_honest(scores(
      long_legs(), [](Frame& frame) { *frame.px_per_m *= 1.02; }, scale, 4000.0, random));
}

TEST(Witnesses, SurfaceLineHasItsInclinationOnThePhotograph) {
  Setup setup = long_legs();
  setup.roll_rad = 2.0 * std::numbers::pi / 180.0;
  check_honest(scores(setup, kNothing, surface, setup.roll_rad, random));
}

TEST(Witnesses, PathsAreAsStraightAsTheirNoise) {
  // Fisher's root has its mean at 1 - 1/(4 nu), a sixth of an sd below 1 of 32 degrees of freedom.
  const Scores s = scores(long_legs(), kNothing, paths, 1.0, random);
  DOUBLES_EQUAL(0.0, s.mean, 0.2 + 4.0 / std::sqrt(kShots));
  DOUBLES_EQUAL(1.0, s.mean_square, 0.1 + 4.0 * std::sqrt(2.0 / kShots));
}

TEST(Witnesses, AreAbsentWithoutASurface) {
  Setup setup = long_legs();
  const auto told = photograph_witnesses(flight_alone(drop(), setup, random));
  CHECK_TRUE(told.has_value());
  CHECK_FALSE(told->gravity_mps2 || told->diameters_px_per_m || told->surface_rad || told->path_residuals);
}
