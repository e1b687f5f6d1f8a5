// Whether noise stated too small is told, and what is then made of it.
#include <array>
#include <cmath>
#include <string>

#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

using StatedSd = std::optional<double> Frame::*;
constexpr std::array<StatedSd, 3> kStated{&Frame::centre_sd_px, &Frame::equator_sd_rad,
                                          &Frame::diameter_sd_px};

Frame with_noise_stated_at(double share, Frame frame) {
  for (const StatedSd sd : kStated) *(frame.*sd) *= share;
  return frame;
}

bool exceeds(const Readout& readout) { return readout.flags.has(Flag::residuals_exceed_noise); }

Readout by_residuals(const Frame& frame) {
  const auto readout =
      reduce(frame, Estimator::best, {.effects = flight::kGravityOnly, .noise = NoiseSource::residuals});
  CHECK_TRUE(readout.has_value());
  return *readout;
}

std::string repeat(std::uint64_t seed) { return ", repeat with STROBE_SEED=" + std::to_string(seed); }

}  // namespace

TEST_GROUP(ResidualTest){};

TEST(ResidualTest, NoiseStatedAtHalfIsToldAndNoGoodImageThrownAwayInsteadOfIt) {
  const std::uint64_t seed = seed_or(31);
  test::Random random(seed);
  constexpr int kShots = 500;
  int told = 0;
  int thrown_away = 0;
  double squares = 0.0;
  for (int i = 0; i < kShots; ++i) {
    const Readout r = reduced(with_noise_stated_at(0.5, test::photograph(Bounce{}, vacuum(), random)));
    told += exceeds(r);
    thrown_away += r.flags.has(Flag::outlier_image);
    squares += *r.residual_ratios.all * *r.residual_ratios.all;
  }
  // 12 + 6 + 9 + 2 = 29 degrees of freedom: chi squared is 116 +- 30 for a limit of 66, but less where an image stood out.
  CHECK_TRUE_TEXT(told > 0.90 * kShots, (std::to_string(told) + repeat(seed)).c_str());
  CHECK_TRUE_TEXT(thrown_away < 0.2 * kShots, (std::to_string(thrown_away) + repeat(seed)).c_str());
  // 500 x 29 degrees of freedom know the mean square to 1.2 %; the outliers of chance are taken out.
  DOUBLES_EQUAL(4.0, squares / kShots, 0.25);
}

TEST(ResidualTest, OneKindStatedTooSmallIsToldByItsRatio) {
  for (std::size_t kind = 0; kind < kStated.size(); ++kind) {
    Frame frame = noisy();
    *(frame.*kStated[kind]) *= 0.2;
    if (kind == 0) frame.surface_sd_px = 2.0;
    const Readout r = reduced(frame);
    CHECK_TRUE_TEXT(exceeds(r), kMeasurementKindNames[kind].data());
    for (std::size_t other = 0; other < kMeasurementKindCount; ++other) {
      const auto& ratio = r.residual_ratios.by_kind[other];
      CHECK_TRUE(ratio.has_value());
      CHECK_EQUAL(other == kind, *ratio > 2.5);
    }
  }
}

TEST(ResidualTest, AnOutlierOfFourThatWasLeftOutLeavesTheNoiseUndoubted) {
  Setup setup = vacuum();
  setup.incoming = setup.rebound = 6;
  Frame frame = noisy(setup);
  frame.images[2].centre_px.x +=
      200.0;  // a hundred sd: no probability is left to tell it from its neighbours
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::outlier_image));
  CHECK_FALSE(exceeds(r));
  frame.images.erase(frame.images.begin() + 2);
  const Readout without = reduced(frame);
  for (const Quantity q :
       {Quantity::vx_td_mps, Quantity::omega_td_radps, Quantity::e, Quantity::dwell_time_ms})
    equal(*without.value[q], r.value[q], 1e-6 * *without.sd[q]);  // the scale to start from differs
}

TEST(ResidualTest, AnOutlierOfThreeThatCannotBeFoundIsTold) {
  Setup setup = vacuum();
  setup.incoming = 3;
  Frame frame = noisy(setup);
  CHECK_FALSE(exceeds(reduced(frame)));
  frame.images[1].centre_px.y += 60.0;
  CHECK_TRUE(exceeds(reduced(frame)));
}

TEST(ResidualTest, AWrongScaleIsNotTakenForNoise) {
  Frame frame = noisy();
  frame.px_per_m = 1.05 * 4000.0;
  CHECK_FALSE(exceeds(reduced(frame)));
}

TEST(ResidualTest, NoiseStatedTooLargeIsSeenInTheRatioAlone) {
  const Readout r = reduced(with_noise_stated_at(10.0, noisy()));
  CHECK_FALSE(exceeds(r));
  CHECK_TRUE(*r.residual_ratios.all < 0.2);
}

TEST(ResidualTest, WithoutStatedNoiseThereIsNoRatio) {
  Setup setup = vacuum();
  setup.state_noise = false;
  const Readout r = reduced(noisy(setup));
  CHECK_FALSE(r.residual_ratios.all.has_value());
  CHECK_FALSE(exceeds(r));
}

TEST(ResidualTest, OfCleanPhotographsOneInAThousandIsDoubted) {
  // At most 12 of 12,000, sd 3.5, within three sd; fewer, since all kinds together repeat what one alone says.
  for (const int images : {2, 5, 20}) {
    const std::uint64_t seed = seed_or(32);
    test::Random random(seed);
    Setup setup = vacuum();
    setup.incoming = setup.rebound = images;
    int doubted = 0;
    for (int i = 0; i < 12000; ++i) doubted += exceeds(reduced(test::photograph(Bounce{}, setup, random)));
    CHECK_TRUE_TEXT(doubted <= 22, (std::to_string(doubted) + repeat(seed)).c_str());
  }
}

TEST_GROUP(NoiseFromResiduals){};

TEST(NoiseFromResiduals, TakesStatedSdsAsRelativeWeights) {
  Frame frame = noisy();
  frame.images[0].centre_cov_px2 = std::array{16.0, 1.0, 1.0, 9.0};
  frame.images[3].diameter_sd_px = 4.0;
  frame.images[4].equator_sd_rad = 0.03;
  const Readout one = by_residuals(frame);
  CHECK_TRUE(one.flags.has(Flag::sd_from_residuals));
  CHECK_FALSE(one.residual_ratios.all.has_value());
  Frame scaled = with_noise_stated_at(0.3, frame);
  for (double& variance : *scaled.images[0].centre_cov_px2) variance *= 0.09;
  *scaled.images[3].diameter_sd_px *= 0.3;
  *scaled.images[4].equator_sd_rad *= 0.3;
  const Readout other = by_residuals(scaled);
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (!one.value[q]) continue;
    // The variances are iterated to 1e-6 of an sd.
    equal(*one.value[q], other.value[q], 1e-5 * *one.sd[q]);
    equal(*one.sd[q], other.sd[q], 1e-5 * *one.sd[q]);
  }
}

TEST(NoiseFromResiduals, AgreesWithNoneStatedWhereAllAreStatedAlike) {
  const Frame stated = noisy();
  Frame unstated = stated;
  for (const StatedSd sd : kStated) (unstated.*sd).reset();
  const Readout one = by_residuals(stated);
  const auto other = reduce(unstated, Estimator::best, {.effects = flight::kGravityOnly});
  for (const Quantity q :
       {Quantity::vx_td_mps, Quantity::omega_lo_radps, Quantity::e, Quantity::dwell_time_ms}) {
    equal(*one.value[q], other->value[q], 1e-5 * *one.sd[q]);
    equal(*one.sd[q], other->sd[q], 1e-5 * *one.sd[q]);
  }
}

TEST(NoiseFromResiduals, SdsHoldWhatTheySayThoughNoiseIsStatedAtHalf) {
  // 68.27 % within an sd: 1,500 shots of two independent numbers know the share to .85 %; within three and the percent of
  // pooling unlike degrees of freedom.
  const std::uint64_t seed = seed_or(33);
  test::Random random(seed);
  const Quantities truth = test::truth(Bounce{});
  int within = 0;
  constexpr int kShots = 1500;
  for (int i = 0; i < kShots; ++i) {
    const Readout r = by_residuals(with_noise_stated_at(0.5, test::photograph(Bounce{}, vacuum(), random)));
    for (const Quantity q : {Quantity::vy_td_mps, Quantity::omega_lo_radps})
      within += std::abs(*r.value[q] - *truth[q]) < *r.sd[q];
  }
  const double share = within / (2.0 * kShots);
  CHECK_TRUE_TEXT(std::abs(share - 0.6827) < 0.036, (std::to_string(share) + repeat(seed)).c_str());
}
