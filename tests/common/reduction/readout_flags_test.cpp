#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "common/reduction/running_statistics.hpp"
#include "common/reduction/shot_fit.hpp"
#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

TEST_GROUP(ReadoutFlags){};

TEST(ReadoutFlags, ALegWithOneImageHasNoNumbers) {
  Frame frame = straight_frame();
  frame.images.erase(frame.images.begin());
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::too_few_images));
  for (const Quantity q :
       {Quantity::vx_td_mps, Quantity::omega_td_radps, Quantity::e, Quantity::mu, Quantity::dwell_time_ms}) {
    CHECK_FALSE(r.value[q].has_value());
    CHECK_FALSE(r.sd[q].has_value());
  }
  CHECK_TRUE(r.value[Quantity::vx_lo_mps].has_value());
  CHECK_FALSE(r.regime.has_value());
}

TEST(ReadoutFlags, NoImagesAtAllIsAReadoutWithoutNumbers) {
  Frame frame = straight_frame();
  frame.images.clear();
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::too_few_images));
  CHECK_TRUE(r.flags.has(Flag::no_contact_image));
  for (std::size_t i = 0; i < kQuantityCount; ++i) CHECK_FALSE(r.value[static_cast<Quantity>(i)].has_value());
}

TEST(ReadoutFlags, WithoutEquatorsOnlyTheSpinIsMissing) {
  Frame frame = straight_frame();
  frame.images[3].equator_rad.reset();
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::too_few_images));
  CHECK_FALSE(r.value[Quantity::omega_lo_radps].has_value());
  CHECK_FALSE(r.value[Quantity::slip_lo_mps].has_value());
  CHECK_TRUE(r.value[Quantity::omega_td_radps].has_value());
  CHECK_TRUE(r.value[Quantity::e].has_value());
}

TEST(ReadoutFlags, SurfacePointsThatAreOnePointAreNoSurface) {
  Frame frame = straight_frame();
  frame.surface_px = {{10, 100}, {10, 100}};
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::degenerate_geometry));
  CHECK_FALSE(r.value[Quantity::vx_td_mps].has_value());
}

TEST(ReadoutFlags, ALegThatLeavesTheSurfaceInsteadOfMeetingItIsDegenerate) {
  Frame frame = straight_frame();
  std::swap(frame.images[0].centre_px, frame.images[1].centre_px);
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::degenerate_geometry));
  CHECK_FALSE(r.value[Quantity::vx_td_mps].has_value());
  CHECK_FALSE(r.value[Quantity::e].has_value());
}

TEST(ReadoutFlags, APhotographWithYDownIsNotReadAsOneWithYUp) {
  Frame frame = straight_frame();
  for (BallImage& i : frame.images) i.centre_px.y = -i.centre_px.y;
  for (PointPx& p : frame.surface_px) p.y = -p.y;
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::overlaps_surface));  // the ball is beneath it
  CHECK_FALSE(r.value[Quantity::e].has_value());
}

TEST(ReadoutFlags, NoContactImageIsSaid) {
  Frame frame = straight_frame();
  frame.images.erase(frame.images.begin() + 2);
  CHECK_TRUE(reduced(frame).flags.has(Flag::no_contact_image));
  CHECK_FALSE(reduced(straight_frame()).flags.has(Flag::no_contact_image));
}

TEST(ReadoutFlags, AnImageLabelledAirborneThatOverlapsTheSurfaceIsLeftOut) {
  const Readout clean = reduced(noisy());
  Frame frame = noisy();
  for (BallImage& i : frame.images) {
    if (i.leg == Leg::contact) {
      i.leg = Leg::incoming;
      break;
    }
  }
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::overlaps_surface));
  CHECK_FALSE(clean.flags.has(Flag::overlaps_surface));
  equal(*clean.value[Quantity::vy_td_mps], r.value[Quantity::vy_td_mps]);
}

TEST(ReadoutFlags, AWrongImageOfFourIsLeftOut) {
  Setup setup = vacuum();
  setup.incoming = setup.rebound = 4;
  for (const std::size_t wrong : {0U, 1U, 2U, 3U}) {
    Frame frame = noisy(setup);
    frame.images[wrong].centre_px.x += 60.0;  // thirty sd: an image of another flash
    const Readout r = reduced(frame);
    CHECK_TRUE(r.flags.has(Flag::outlier_image));
    DOUBLES_EQUAL(15.62, *r.value[Quantity::vx_td_mps], 4.0 * *r.sd[Quantity::vx_td_mps]);
    CHECK_FALSE(reduced(noisy(setup)).flags.has(Flag::outlier_image));
  }
}

TEST(ReadoutFlags, AnImageThatDoesNotFitCountsLikeTheOthersWhereOutliersAreKept) {
  const Frame clean = noisy();
  const auto vx_with = [&](double displaced_px) {
    Frame frame = clean;
    frame.images[1].centre_px.x += displaced_px;
    const auto r = reduce(frame, Estimator::best, {.effects = flight::Effects{}, .reject_outliers = false});
    CHECK_TRUE(r.has_value());
    CHECK_FALSE(r->flags.has(Flag::outlier_image));
    return *r->value[Quantity::vx_td_mps];
  };
  // A straight line's slope is linear in its points; the common scale and tilt bend that by the square of the
  // displacement over the path, (120 px/1800 px)^2.
  const double one = vx_with(60.0) - vx_with(0.0);
  const double two = vx_with(120.0) - vx_with(0.0);
  CHECK_TRUE(std::abs(one) > 1e-3);
  DOUBLES_EQUAL(2.0 * one, two, 5e-3 * std::abs(two));
}

TEST(ReadoutFlags, FewerThanFourImagesOfALegAreSaidToHaveNoRedundancy) {
  for (const int images : {2, 3, 4, 5}) {
    Setup setup = vacuum();
    setup.rebound = images;
    const bool said = reduced(noisy(setup)).flags.has(Flag::no_redundancy);
    CHECK_EQUAL(images < 4, said);
  }
}

TEST(ReadoutFlags, TwoOrThreeEquatorsOrDiametersAreSaidToHaveNoRedundancy) {
  for (const int equators : {2, 3, 4, 5}) {
    Frame frame = noisy();
    for (int i = equators; i < 5; ++i) frame.images[static_cast<std::size_t>(i)].equator_rad.reset();
    CHECK_EQUAL(equators < 4, reduced(frame).flags.has(Flag::no_redundancy));
  }
  // A calibrated scale: the ball's tolerance is the larger, no diameter is in use.
  Setup setup = vacuum();
  Frame frame = noisy(setup);
  frame.px_per_m = setup.px_per_m, frame.px_per_m_sd = 1.0, frame.ball_diameter_sd_m = 1e-3;
  CHECK_FALSE(reduced(frame).flags.has(Flag::no_redundancy));
}

TEST(ReadoutFlags, TwoWrongEquatorsOfEightDoNotMaskEachOther) {
  Setup setup = vacuum();
  setup.incoming = setup.rebound = 8;
  Bounce b;
  b.omega_td = 258.5, b.omega_lo = -60.0;
  for (const bool stated : {true, false}) {
    setup.state_noise = stated;
    for (std::size_t one = 0; one < 8; ++one) {
      for (std::size_t other = one + 1; other < 8; ++other) {
        test::Random random(100 * one + other);
        Frame frame = test::photograph(b, setup, random);
        *frame.images[one].equator_rad += 0.785;
        *frame.images[other].equator_rad += 0.785;
        const Readout r = reduced(frame);
        CHECK_TRUE(r.flags.has(Flag::outlier_image));
        // Student's factor of an estimated noise is in the sd; 56 draws.
        DOUBLES_EQUAL(258.5, *r.value[Quantity::omega_td_radps], 5.0 * *r.sd[Quantity::omega_td_radps]);
        CHECK_TRUE(*r.sd[Quantity::omega_td_radps] < 4.0);
      }
    }
  }
}

TEST(ReadoutFlags, AWrongEquatorOfFiveIsLeftOutAndTheFlightKept) {
  Frame frame = noisy();
  const Readout clean = reduced(frame);
  *frame.images[2].equator_rad += 0.8;
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::outlier_image));
  DOUBLES_EQUAL(2.61, *r.value[Quantity::omega_td_radps], 4.0 * *r.sd[Quantity::omega_td_radps]);
  equal(*clean.value[Quantity::vx_td_mps], r.value[Quantity::vx_td_mps]);
}

TEST(ReadoutFlags, AnImageWhoseTimeIsUncertainIsNoOutlierForBeingEarlyOrLate) {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.equator_sd_rad = 0.001;
  Frame frame = noisy(setup);
  BallImage& image = frame.images[frame.images.size() - 3];
  image.time_s += 60e-6;  // at -313 rad/s 19 sd of the equator
  CHECK_TRUE(reduced(frame).flags.has(Flag::outlier_image));
  image.time_sd_s = 100e-6;
  CHECK_FALSE(reduced(frame).flags.has(Flag::outlier_image));
}

TEST(ReadoutFlags, CleanPhotographsLoseAnImageOnceInAThousand) {
  // 12 of 12,000, sd 3.5, whether noise is stated or estimated; within three sd.
  for (const bool stated : {true, false}) {
    Setup setup = vacuum();
    setup.state_noise = stated;
    test::Random random(11);
    int flagged = 0;
    for (int i = 0; i < 12000; ++i) {
      FlagSet flags;
      const ShotFit fit =
          fit_shot(*observe(test::photograph(Bounce{}, setup, random), flags), {flight::kGravityOnly}, flags);
      const bool lost = std::ranges::any_of(fit.observations.images, [](const Observation& o) {
        return o.leg != Leg::contact && !(o.use_centre && o.use_diameter && o.use_equator);
      });
      CHECK_EQUAL(lost, flags.has(Flag::outlier_image));
      flagged += lost;
    }
    CHECK_TRUE_TEXT(flagged >= 2 && flagged <= 22, std::to_string(flagged).c_str());
  }
}

TEST(ReadoutFlags, SpinNearTheLimitOfAQuarterTurnIsFlagged) {
  Setup setup = vacuum();
  Bounce b;
  b.omega_td = 515.0;  // the limit is pi / (2 * 3 ms) = 523.6
  test::Random random(5);
  CHECK_TRUE(reduced(test::photograph(b, setup, random)).flags.has(Flag::spin_aliased));
  b.omega_td = 400.0;
  CHECK_FALSE(reduced(test::photograph(b, setup, random)).flags.has(Flag::spin_aliased));
}

TEST(ReadoutFlags, ASpinBeyondAQuarterTurnIsFlaggedByWhatFrictionTookFromTheTravel) {
  Bounce b;  // 692 rad/s are 2.08 rad in 3 ms, and read as -1.06
  b.vx_td = 32.0;
  b.vx_lo = 22.8;
  b.omega_td = -100.0;
  b.omega_lo = -692.0;
  test::Random random(6);
  const Frame frame = test::photograph(b, vacuum(), random);
  const Readout r = reduced(frame);
  CHECK_TRUE(*r.value[Quantity::omega_lo_radps] > 0.0);
  CHECK_TRUE(r.flags.has(Flag::spin_aliased));
  // Likewise where the first fit is the last one, and of two images.
  CHECK_TRUE(reduce(frame, Estimator::best)->flags.has(Flag::spin_aliased));
  CHECK_TRUE(
      reduce(frame, Estimator::best, {.effects = flight::kGravityOnly})->flags.has(Flag::spin_aliased));
  CHECK_TRUE(reduced(frame, Estimator::two_point).flags.has(Flag::spin_aliased));
}

TEST(ReadoutFlags, ASpinThatALegWithGapsCannotTellIsFlaggedThoughFrictionAllowsIt) {
  // Every other image of the leg is lacking: 6 ms tell spins up to 262 rad/s, and -295 reads as 229. Friction
  // and a strong offset of the normal force make both plausible.
  Bounce b;
  b.vx_td = 12.0, b.vx_lo = 5.9, b.vy_td = -10.0, b.vy_lo = 8.5;
  b.omega_td = -295.0, b.omega_lo = -227.0;
  test::Random random(8);
  Frame frame = test::photograph(b, vacuum(), random);
  frame.images.erase(frame.images.begin() + 3);
  frame.images.erase(frame.images.begin() + 1);
  const Readout r = reduced(frame);
  CHECK_TRUE(*r.value[Quantity::omega_td_radps] > 0.0);
  CHECK_TRUE(r.flags.has(Flag::spin_aliased));
}

TEST(ReadoutFlags, ASpinThatUnreadEquatorsLeaveOpenIsFlaggedAndTheRegimeUnclear) {
  // Equators of the first and fourth image alone, 9 ms: 259 rad/s, 349 less or 349 less again.
  Bounce b;
  b.vx_td = 9.0, b.vy_td = -15.3, b.omega_td = 259.0;
  b.vx_lo = 3.2, b.vy_lo = 12.7, b.omega_lo = -65.0;
  Frame frame = noisy();
  test::Random random(3);
  frame = test::photograph(b, vacuum(), random);
  CHECK_FALSE(reduced(frame).flags.has(Flag::spin_aliased));
  for (const std::size_t unread : {1U, 2U, 4U}) frame.images[unread].equator_rad.reset();
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::spin_aliased));
  CHECK_TRUE(r.regime == Regime::unclear);
}

TEST(ReadoutFlags, NoPeriodIsSoLongThatAnAliasedSpinGoesUnflagged) {
  // Friction allows both: a topspin that hardly slips, and half a turn a flash more with which the ball slid.
  Bounce b;
  b.omega_td = -350.0, b.vx_lo = 13.6, b.omega_lo = -450.0;
  for (const double period_s : {5e-3, 6.9e-3, 7.1e-3, 9e-3, 15e-3}) {
    Setup setup = vacuum();
    setup.period_s = period_s;
    test::Random random(4);
    const Readout r = reduced(test::photograph(b, setup, random));
    CHECK_TRUE(std::abs(*r.value[Quantity::omega_td_radps] + 350.0) > 100.0);
    CHECK_TRUE(r.flags.has(Flag::spin_aliased));
    CHECK_FALSE(r.court_pace_conforming);
  }
}

namespace {

bool told_by(const Readout& r, SpinEvidence evidence) { return r.spin_told_by.has(evidence); }

Setup untold() {
  Setup setup;
  setup.fastest_spin_radps.reset();
  return setup;
}

/// A ball that slides throughout: Coulomb's friction, alpha 0.55.
Bounce sliding(double omega_td) {
  Bounce b;
  b.vx_td = 18.0, b.vy_td = -6.1, b.vy_lo = 4.9, b.omega_td = omega_td;
  const double change = 0.57 * (b.vy_lo - b.vy_td);
  b.vx_lo = b.vx_td - change;
  b.omega_lo = omega_td - change / (0.55 * 0.5 * b.diameter_m);
  return b;
}

}  // namespace

TEST(ReadoutFlags, ASpinThatNoFlashTellsFromAFasterOneIsToldByAnAssumption) {
  test::Random random(11);
  Frame frame = test::photograph(sliding(-95.0), untold(), random);
  const Readout assumed = test::reduced_in_air(frame);
  CHECK_TRUE(assumed.flags.has(Flag::spin_limit_assumed));
  CHECK_TRUE(told_by(assumed, SpinEvidence::assumed_limit));
  frame.fastest_spin_radps = 600.0;
  const Readout stated = test::reduced_in_air(frame);
  CHECK_FALSE(stated.flags.has(Flag::spin_limit_assumed));
  CHECK_FALSE(told_by(stated, SpinEvidence::assumed_limit));
  CHECK_TRUE(assumed.value == stated.value && assumed.sd == stated.sd);
  frame.fastest_spin_radps = 1200.0;
  const Readout open = test::reduced_in_air(frame);
  CHECK_TRUE(open.flags.has(Flag::spin_aliased));
  CHECK_TRUE(open.spin_told_by.empty());
}

TEST(ReadoutFlags, NoFastBackspinIsReadAsAnotherInSilence) {
  // Half a turn in 3 ms less, 1047 rad/s, looks the same.
  test::Random random(12);
  for (double omega = 800.0; omega < 1500.0; omega += 10.0) {
    const Readout r = test::reduced_in_air(test::photograph(sliding(omega), untold(), random));
    const bool right = std::abs(*r.value[Quantity::omega_td_radps] - omega) < 20.0;
    CHECK_TRUE_TEXT(right || r.flags.has(Flag::spin_limit_assumed) || r.flags.has(Flag::spin_aliased),
                    std::to_string(omega).c_str());
  }
}

TEST(ReadoutFlags, TheAirsLiftTellsFastSpinsFromSlowOnesWherePathsAreKnownWell) {
  Setup setup = untold();
  setup.centre_sd_m = setup.surface_sd_m = 0.02e-3;
  test::Random random(13);
  const Readout r = test::reduced_in_air(test::photograph(sliding(-95.0), setup, random));
  CHECK_TRUE(told_by(r, SpinEvidence::lift));
  CHECK_FALSE(r.flags.has(Flag::spin_limit_assumed));
}

TEST(ReadoutFlags, UnequalIntervalsTellAnySpin) {
  Setup setup = untold();
  setup.flash_jitter_s = 0.5e-3;
  test::Random random(14);
  int told = 0;
  for (int i = 0; i < 30; ++i) {
    const double omega = 50.0 * i;
    const Readout r = test::reduced_in_air(test::photograph(sliding(omega), setup, random));
    if (r.flags.has(Flag::spin_aliased) || r.flags.has(Flag::spin_limit_assumed)) continue;
    ++told;
    // Of angles known to a degree, five over 12 ms: 1.8 rad/s.
    CHECK_TRUE_TEXT(std::abs(*r.value[Quantity::omega_td_radps] - omega) < 15.0, std::to_string(omega).c_str());
  }
  // Some intervals are nearly equal by chance.
  CHECK_TRUE_TEXT(told >= 27, std::to_string(told).c_str());
}

TEST(ReadoutFlags, NoBounceOfTheThesisBelowTheLimitContradictsFriction) {
  test::Random random(7);
  for (const Bounce& b : test::thesis_bounces()) {
    if (std::max(std::abs(b.omega_td), std::abs(b.omega_lo)) > 450.0) continue;  // near pi / (2 * 3 ms)
    CHECK_FALSE_TEXT(reduced(test::photograph(b, vacuum(), random)).flags.has(Flag::spin_aliased),
                     b.label.c_str());
  }
}

TEST(ReadoutFlags, NoiseFromResidualsIsSaid) {
  Setup setup = vacuum();
  setup.state_noise = false;
  const Readout r = reduced(noisy(setup));
  CHECK_TRUE(r.flags.has(Flag::sd_from_residuals));
  CHECK_TRUE(r.sd[Quantity::e].has_value());
  CHECK_FALSE(reduced(noisy()).flags.has(Flag::sd_from_residuals));
}

TEST(ReadoutFlags, StatedErrorsInTimeAreNotTakenForNoiseOfTheEquators) {
  // Times err by 20 us, which at -313 rad/s are 0.0063 rad, and nobody stated the equators' 0.01 rad. Some six
  // degrees of freedom a shot: 400 shots know the mean square to sqrt(2 / 2400) = 2.9 %; with the time's
  // error it would be 20 % more.
  Setup setup = vacuum();
  setup.equator_sd_rad = 0.01;
  test::Random random(12);
  std::normal_distribution<double> time_error(0.0, 20e-6);
  RunningStatistics squares;
  for (int i = 0; i < 400; ++i) {
    Frame frame = test::photograph(Bounce{}, setup, random);
    frame.equator_sd_rad.reset();
    for (BallImage& image : frame.images) image.time_s += time_error(random), image.time_sd_s = 20e-6;
    FlagSet flags;
    const ShotFit fit = fit_shot(*observe(frame, flags), {}, flags);
    const double sd = fit.observations.group_sd[NoiseGroup::equator];
    squares.add(sd * sd);
  }
  DOUBLES_EQUAL(1e-4, squares.mean(), 0.1e-4);
}

TEST(ReadoutFlags, EstimatedNoiseHasSettled) {
  Setup setup = vacuum();
  setup.state_noise = false;
  FlagSet flags;
  ShotFit fit = fit_shot(*observe(noisy(setup), flags), {}, flags);
  const auto before = fit.observations.group_sd.sd;
  refit(fit, fit.effects);
  for (std::size_t i = 0; i < kNoiseGroupCount; ++i)
    DOUBLES_EQUAL(before[i], fit.observations.group_sd.sd[i], 1e-6 * before[i]);
}

TEST(ReadoutFlags, NoResidualsMeanNoSd) {
  Frame frame = straight_frame();
  frame.equator_sd_rad.reset();  // two equators a leg: no residual to know their noise from
  const Readout r = reduced(frame);
  CHECK_TRUE(r.value[Quantity::omega_td_radps].has_value());
  CHECK_FALSE(r.sd[Quantity::omega_td_radps].has_value());
  CHECK_FALSE(r.sd[Quantity::slip_lo_mps].has_value());
  CHECK_TRUE(r.sd[Quantity::vx_td_mps].has_value());
}

TEST(ReadoutFlags, ALineThroughTwoPointsOfUnknownNoiseLeavesAnglesWithoutSd) {
  Frame frame = straight_frame();
  frame.surface_px.resize(2);
  frame.centre_sd_px.reset();
  for (BallImage& image : frame.images) image.centre_cov_px2 = std::array{0.25, 0.0, 0.0, 0.25};
  const Readout r = reduced(frame);
  CHECK_FALSE(r.sd[Quantity::theta_in_deg].has_value());
  CHECK_TRUE(r.sd[Quantity::omega_td_radps].has_value());
}
