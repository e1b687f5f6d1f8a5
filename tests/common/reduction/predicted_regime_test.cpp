// A predicted rebound, photographed and reduced, is of the regime that was predicted.
#include <cmath>
#include <cstdio>
#include <random>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/reduction/reduced_frames.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

struct Contact {
  impact::Motion touchdown;
  impact::Coefficients coefficients;
};

/// Near and far of the border, with and without tangential restitution and offset.
Contact draw(std::mt19937_64& source) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(source);
  };
  const bool rigid = between(0.0, 1.0) < 0.3;
  Contact out;
  out.touchdown = {between(8.0, 16.0), -between(5.0, 12.0), between(-150.0, 150.0)};
  out.coefficients.e = between(0.6, 0.9);
  out.coefficients.mu = between(0.1, 0.7);
  if (!rigid) out.coefficients.e_x = between(-0.1, 0.2);
  if (!rigid) out.coefficients.offset_m = between(0.0, 0.004);
  return out;
}

Readout measured(const Contact& contact, const impact::Rebound& rebound, std::uint64_t seed) {
  Bounce b;
  b.vx_td = contact.touchdown.vx_mps, b.vy_td = contact.touchdown.vy_mps,
  b.omega_td = contact.touchdown.omega_radps;
  b.vx_lo = rebound.lift_off.vx_mps, b.vy_lo = rebound.lift_off.vy_mps,
  b.omega_lo = rebound.lift_off.omega_radps;
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = 0.02e-3;
  setup.equator_sd_rad = 0.001;
  test::Random random(seed);
  Frame frame = test::photograph(b, setup, random);
  frame.ball_alpha_sd = 0.0;
  return reduced(frame);
}

}  // namespace

TEST_GROUP(PredictedRegime){};

TEST(PredictedRegime, ReducedFromAnExactFrameItIsTheSameOrUnclearAtTheBorder) {
  const std::uint64_t seed = test::seed_or(20250223);
  std::printf("[predicted regime: STROBE_SEED=%llu] ", static_cast<unsigned long long>(seed));
  std::mt19937_64 source(seed);
  const ball::Ball ball;
  int slides = 0, grips = 0, unclear = 0, reversed = 0;
  for (int i = 0; i < 1000; ++i) {
    const Contact contact = draw(source);
    const impact::Rebound rebound = *impact::grip(ball, contact.touchdown, contact.coefficients);
    const Regime predicted = impact::regime_of(ball, contact.touchdown, rebound);
    const Readout readout = measured(contact, rebound, seed + static_cast<std::uint64_t>(i));
    reversed += predicted != rebound.regime ? 1 : 0;
    if (readout.regime == Regime::unclear) {
      ++unclear;
      continue;
    }
    (predicted == Regime::slides ? slides : grips) += 1;
    const double missing =
        short_of_rolling_mps(contact.touchdown.vx_mps + ball.radius_m() * contact.touchdown.omega_radps,
                             contact.touchdown.vx_mps - rebound.lift_off.vx_mps, ball.alpha);
    // On the border itself (a rigid ball that rolls off) the digits of the frame decide.
    if (std::abs(missing) > 1e-6) CHECK_TRUE(*readout.regime == predicted);
  }
  std::printf("slides %d, grips %d, unclear %d, friction's limit elsewhere %d ", slides, grips, unclear,
              reversed);
  CHECK(slides > 200 && grips > 200 && unclear < 250 && reversed > 10);
}

// What friction at its limit takes off may be all that rolling needs, and less than a grip with restitution does.
TEST(PredictedRegime, FrictionAtItsLimitThatEndsTheSlipIsAGrip) {
  const ball::Ball ball;
  const impact::Motion touchdown{12.0, -8.0, 0.0};
  const double rolling = 12.0 * ball.alpha / (1.0 + ball.alpha), impulse = 1.8 * 8.0;
  const auto predicted = [&](double share) {
    const auto rebound =
        impact::grip(ball, touchdown, {.e = 0.8, .mu = share * rolling / impulse, .e_x = 0.1});
    CHECK_TRUE(rebound->regime == Regime::slides);
    return impact::regime_of(ball, touchdown, *rebound);
  };
  CHECK_TRUE(predicted(0.99) == Regime::slides);
  CHECK_TRUE(predicted(1.05) == Regime::grips);
  CHECK_TRUE(regime_of_exact(12.0, rolling * (1.0 - 1e-15), ball.alpha) == Regime::grips);
}
