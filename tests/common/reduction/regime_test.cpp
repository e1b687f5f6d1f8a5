// Whether the ball slid or gripped.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <utility>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/common/reduction/reduced_frames.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

TEST_GROUP(Regime21){};

TEST(Regime21, OnlyTheThreeShallowSetsSlideThroughout) {
  // Known from the thesis's measured means: zero -17, back -17 and back -22 slide, the others grip.
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = 0.02e-3;
  setup.equator_sd_rad = 0.001;
  for (const Bounce& b : test::thesis_bounces()) {
    test::Random random(1);
    const Readout r = reduced(test::photograph(b, setup, random));
    const bool slides = b.label == "zero_17" || b.label == "back_17" || b.label == "back_22";
    CHECK_TRUE_TEXT(r.regime == (slides ? Regime::slides : Regime::grips), b.label.c_str());
  }
}

TEST(Regime21, TheBallsInertiaDecidesWhatRollingNeeds) {
  // Slip 15 - 3.25 = 11.75 m/s, of which alpha / (1 + alpha), 0.355 at 0.55, must go to roll: 4.17 of the 6
  // that vx lost, so it gripped.
  Frame frame = straight_frame();
  frame.images[1].equator_rad = 0.1 - 0.2 + std::numbers::pi;
  CHECK_EQUAL(Regime::grips, reduced(frame).regime);
  // With backspin the slip is 18.25 m/s.
  frame.images[1].equator_rad = 0.1 + 0.2;
  frame.ball_alpha = 0.3;
  CHECK_EQUAL(Regime::grips, reduced(frame).regime);  // needs 4.21
  frame.ball_alpha = 2.0 / 3.0;
  CHECK_EQUAL(Regime::slides, reduced(frame).regime);  // needs 7.3
}

TEST(Regime21, WithinTwoSdItIsUnclear) {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  test::Random random(1);
  Frame frame = test::photograph(test::thesis_bounces().front(), setup, random);  // 0.95 m/s short of rolling
  frame.ball_alpha_sd = 0.0;
  const Readout r = *reduce(frame, Estimator::best, {.effects = flight::kGravityOnly, .covariance = true});
  // missing = (vx + R omega) alpha / (1 + alpha) - (vx - vx_lo), at an alpha of 0.55
  const double share = 0.55 / 1.55, radius_m = 0.5 * frame.ball_diameter_m;
  const double vx = *r.value[Quantity::vx_td_mps];
  const double missing =
      (vx + radius_m * *r.value[Quantity::omega_td_radps]) * share - (vx - *r.value[Quantity::vx_lo_mps]);
  const std::pair<std::size_t, double> gradient[] = {{0, share - 1.0}, {2, radius_m * share}, {4, 1.0}};
  double variance = 0.0;
  for (const auto& [i, by_i] : gradient) {
    for (const auto& [k, by_k] : gradient) variance += by_i * by_k * (*r.covariance)[i][k];
  }
  const auto regime_at = [&](double sds) {  // every sd is proportional to the stated ones
    Frame noisier = frame;
    const double factor = missing / std::sqrt(variance) / sds;
    *noisier.centre_sd_px *= factor, *noisier.diameter_sd_px *= factor, *noisier.equator_sd_rad *= factor;
    return reduced(noisier).regime;
  };
  CHECK_TRUE(regime_at(1.99) == Regime::unclear);
  CHECK_TRUE(regime_at(2.01) == Regime::slides);
}

TEST(Regime21, ABallThatRolledIsNotCalledSlidingForAnAlphaWithinItsTolerance) {
  // Balls of 0.51 to 0.60, told 0.55, that just come to roll: vx loses |slip| alpha / (1 + alpha). The noise is
  // a hundredth of the tolerance's 0.12 m/s, and 0.51 is 1.7 of its sd.
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = 0.01e-3;
  setup.equator_sd_rad = 0.0003;
  for (const double alpha : {0.51, 0.53, 0.549, 0.60}) {
    Bounce b;
    b.omega_td = 100.0;
    const double lost = (b.vx_td + 0.5 * b.diameter_m * b.omega_td) * alpha / (1.0 + alpha);
    b.vx_lo = b.vx_td - lost;
    b.omega_lo = -b.vx_lo / (0.5 * b.diameter_m);
    test::Random random(1);
    Frame frame = test::photograph(b, setup, random);
    CHECK_TRUE(reduced(frame).regime == (alpha < 0.55 ? Regime::unclear : Regime::grips));
    frame.ball_alpha_sd = 0.0;
    CHECK_TRUE(reduced(frame).regime == (alpha < 0.55 ? Regime::slides : Regime::grips));
    frame.ball_alpha = alpha - 1e-3;
    CHECK_TRUE(reduced(frame).regime == Regime::grips);
  }
}

// A predicted rebound, photographed and reduced, is of the regime that was predicted.

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
