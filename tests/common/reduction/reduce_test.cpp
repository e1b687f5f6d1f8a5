// What a readout says of frames that are plain, poor or wrong. Numbers are worked out by hand in the
// comments.
#include <cmath>
#include <numbers>
#include <string>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;

namespace {

constexpr double kPi = std::numbers::pi;

BallImage image(double time_ms, Leg leg, double x, double y, double equator) {
  BallImage out;
  out.time_s = time_ms * 1e-3;
  out.leg = leg;
  out.centre_px = {x, y};
  out.diameter_px = 65.0;
  out.equator_rad = equator;
  return out;
}

/// 1000 px to the metre, ball of 65 mm, surface at y = 100, so touchdown and lift-off at y = 132.5.
/// In at (15, -6) m/s, that is 15 and 6 px a millisecond; touchdown at 4 ms, x = 150. Out at (9, 5) m/s;
/// lift-off at 9 ms, x = 200. Spin -100 before, written past the half turn (0.1 - 0.2 + pi), and 150 rad/s
/// after.
Frame straight_frame() {
  Frame frame;
  frame.shot_id = 7;
  frame.ball_diameter_m = 0.065;
  frame.surface_px = {{0, 100}, {100, 100}, {200, 100}, {300, 100}};
  frame.centre_sd_px = 0.5;
  frame.diameter_sd_px = 0.5;
  frame.equator_sd_rad = 0.01;
  frame.images = {image(0, Leg::incoming, 90, 156.5, 0.1), image(2, Leg::incoming, 120, 144.5, kPi - 0.1),
                  image(6, Leg::contact, 170, 120, 0.0), image(10, Leg::rebound, 209, 137.5, 1.5),
                  image(12, Leg::rebound, 227, 147.5, 1.8)};
  return frame;
}

/// These photographs are of flight without air.
Readout reduced(const Frame& frame, Estimator estimator = Estimator::best) {
  const auto readout = reduce(frame, estimator, {.effects = flight::kGravityOnly});
  if (!readout) FAIL(readout.error().message.c_str());
  return *readout;
}

std::string complaint(const Frame& frame) {
  const auto readout = reduce(frame, Estimator::best);
  return readout ? "accepted" : readout.error().message;
}

void equal(double expected, const std::optional<double>& actual, double tolerance = 1e-9) {
  CHECK_TRUE(actual.has_value());
  DOUBLES_EQUAL(expected, *actual, tolerance);
}

Setup vacuum() {
  Setup setup;
  setup.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  return setup;
}

Frame noisy(const Setup& setup = vacuum(), std::uint64_t seed = 3) {
  test::Random random(seed);
  return test::photograph(Bounce{}, setup, random);
}

}  // namespace

TEST_GROUP(TwoPoint){};

TEST(TwoPoint, GivesTheNumbersWorkedOutByHand) {
  Frame frame = straight_frame();
  frame.temperature_c = 13.0;
  const Readout r = reduced(frame, Estimator::two_point);
  LONGS_EQUAL(7, r.shot_id);
  STRCMP_EQUAL("two-point", r.method.c_str());
  equal(15.0, r.value[Quantity::vx_td_mps]);
  equal(-6.0, r.value[Quantity::vy_td_mps]);
  equal(std::sqrt(261.0), r.value[Quantity::v_td_mps]);
  equal(-21.80140948635181, r.value[Quantity::theta_in_deg]);  // atan(6 / 15)
  equal(29.05460409907715, r.value[Quantity::theta_out_deg]);  // atan(5 / 9)
  equal(-100.0, r.value[Quantity::omega_td_radps]);
  equal(150.0, r.value[Quantity::omega_lo_radps]);
  equal(9.0, r.value[Quantity::vx_lo_mps]);
  equal(5.0, r.value[Quantity::vy_lo_mps]);
  equal(9.0 + 0.0325 * 150.0, r.value[Quantity::slip_lo_mps]);
  equal(5.0 / 6.0, r.value[Quantity::e]);
  equal(6.0 / 11.0, r.value[Quantity::mu]);
  equal(5.0, r.value[Quantity::dwell_time_ms]);
  equal(5.0, r.value[Quantity::dwell_distance_cm]);
  // e at 23 degrees: 5/6 + 0.003 * 10; 100 (1 - 6/11) + 150 (0.81 - 0.8633...) = 45.4545... - 8
  equal(500.0 / 11.0 - 8.0, r.value[Quantity::court_pace]);
  CHECK_FALSE(r.court_pace_conforming);
  CHECK_FALSE(r.mirrored);
  CHECK_TRUE(r.flags.has(Flag::no_redundancy));
}

TEST(TwoPoint, StandardDeviationsFollowFromTheTwoImages) {
  const Readout r = reduced(straight_frame(), Estimator::two_point);
  // Spin: two angles of 0.01 rad over 2 ms.
  equal(0.01 * std::sqrt(2.0) / 2e-3, r.sd[Quantity::omega_td_radps]);
  // vx = 30 px / 2 ms / scale. Positions: 0.5 px each, so 0.5 sqrt 2 / 2 ms = 0.353553 m/s; scale: four
  // diameters of 0.5 px in 65 give 0.384615 %, of 15 m/s 0.0576923; tilt: points at -150, -50, 50, 150 from
  // their mean have a moment of 50000 px^2, so 0.5 / sqrt(50000) = 2.23607e-3 rad, times vy of 6 gives
  // 0.0134164.
  equal(std::sqrt(0.35355339059327 * 0.35355339059327 + 0.05769230769231 * 0.05769230769231 +
                  0.01341640786500 * 0.01341640786500),
        r.sd[Quantity::vx_td_mps]);
}

TEST(TwoPoint, IgnoresAllButTheImagesNextToTheImpact) {
  Frame frame = straight_frame();
  BallImage far = image(-2, Leg::incoming, 70, 190, 2.0);
  frame.images.insert(frame.images.begin(), far);
  const Readout r = reduced(frame, Estimator::two_point);
  equal(15.0, r.value[Quantity::vx_td_mps]);
  equal(-100.0, r.value[Quantity::omega_td_radps]);
}

TEST_GROUP(BestEstimator){};

TEST(BestEstimator, RecoversExactFlightExactly) {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.incline_rad = 0.1;
  const Readout r = reduced(noisy(setup));
  const Quantities truth = test::truth(Bounce{});
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    // 1e-16 of rounding in pixels of 1000, over 3 ms, in units of each number: 1e-10 relative at worst.
    if (truth[q]) equal(*truth[q], r.value[q], 1e-9 * std::max(1.0, std::abs(*truth[q])));
  }
  CHECK_TRUE(r.flags.empty());
}

TEST(BestEstimator, TimeAndLengthMayHaveAnyOriginAndScale) {
  Setup setup = vacuum();
  const Readout plain = reduced(noisy(setup));
  for (const double scale : {1e-3, 1e6}) {
    setup.px_per_m = 4000.0 * scale;
    setup.origin_x_px = 1200.0 * scale;
    setup.origin_y_px = 300.0 * scale;
    const Readout scaled = reduced(noisy(setup));
    equal(*plain.value[Quantity::e], scaled.value[Quantity::e], 1e-9);
    equal(*plain.value[Quantity::vx_td_mps], scaled.value[Quantity::vx_td_mps], 1e-8);
    equal(*plain.sd[Quantity::dwell_distance_cm], scaled.sd[Quantity::dwell_distance_cm], 1e-9);
  }
  setup = vacuum();
  setup.time_origin_s = 1e6;  // a double has steps of 0.12 ns there, that is 1e-7 of 3 ms
  const Readout late = reduced(noisy(setup));
  equal(*plain.value[Quantity::vx_td_mps], late.value[Quantity::vx_td_mps], 1e-5);
  equal(*plain.value[Quantity::omega_lo_radps], late.value[Quantity::omega_lo_radps], 1e-4);
  equal(*plain.value[Quantity::dwell_time_ms], late.value[Quantity::dwell_time_ms], 1e-6);
}

TEST(BestEstimator, AHundredMetresASecondAreNoTrouble) {
  Bounce fast;
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  fast.vx_td = 97.0, fast.vy_td = -24.0, fast.vx_lo = 60.0, fast.vy_lo = 18.0, fast.dwell_x_m = 0.3;
  test::Random random(1);
  const Readout r = reduced(test::photograph(fast, setup, random));
  equal(97.0, r.value[Quantity::vx_td_mps], 1e-8);
  equal(0.75, r.value[Quantity::e], 1e-9);
}

TEST(BestEstimator, ADropFromFiveCentimetresIsMostlyGravity) {
  Bounce drop;
  drop.vx_td = 0.1, drop.vy_td = -1.0, drop.omega_td = 0.0;
  drop.vx_lo = 0.08, drop.vy_lo = 0.75, drop.omega_lo = -1.5, drop.dwell_x_m = 0.0005;
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.period_s = 0.01;
  test::Random random(1);
  const Readout r = reduced(test::photograph(drop, setup, random));
  equal(0.1, r.value[Quantity::vx_td_mps], 1e-9);
  equal(0.75, r.value[Quantity::e], 1e-9);
}

TEST(BestEstimator, LargeTiltsAreTurnedBack) {
  Setup setup = vacuum();
  const Readout plain = reduced(noisy(setup));
  for (const double tilt : {-1.2, 0.8, 1.5}) {
    setup.roll_rad = tilt;
    setup.noise_factor = 0.0;
    const Readout r = reduced(noisy(setup));
    equal(-6.71, r.value[Quantity::vy_td_mps], 1e-8);
    equal(-313.2, r.value[Quantity::omega_lo_radps], 1e-6);
    DOUBLES_EQUAL(*plain.sd[Quantity::e], *r.sd[Quantity::e], 2e-3);
  }
}

TEST(BestEstimator, ABallToTheLeftIsMirrored) {
  Setup setup = vacuum();
  setup.incline_rad = 0.2;
  const Readout right = reduced(noisy(setup));
  setup.mirror = true;
  const Readout left = reduced(noisy(setup));
  CHECK_FALSE(right.mirrored);
  CHECK_TRUE(left.mirrored);
  for (std::size_t i = 0; i + 1 < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    equal(*right.value[q], left.value[q], 1e-9 * std::max(1.0, std::abs(*right.value[q])));
    equal(*right.sd[q], left.sd[q], 1e-9);
  }
}

TEST(BestEstimator, TheDiametersToleranceMovesSpeedsButNotRatiosAnglesOrSpin) {
  Frame frame = noisy();
  frame.ball_diameter_sd_m = 0.0008;
  const Readout r = reduced(frame);
  // Speeds and distances are the diameter times something measured; gravity, in metres, takes off some 0.2 %.
  equal(*r.value[Quantity::v_td_mps] * 0.0008 / 0.0651, r.sd_systematic[Quantity::v_td_mps], 1e-3);
  equal(*r.value[Quantity::dwell_distance_cm] * 0.0008 / 0.0651, r.sd_systematic[Quantity::dwell_distance_cm],
        1e-3);
  for (const Quantity q : {Quantity::e, Quantity::mu, Quantity::theta_in_deg, Quantity::dwell_time_ms}) {
    // Immune but for gravity, which is in metres: some 0.2 % of the fall's share.
    CHECK_TRUE(*r.sd_systematic[q] < 0.02 * *r.sd[q]);
  }
  equal(0.0, r.sd_systematic[Quantity::omega_lo_radps]);
  frame.ball_diameter_sd_m.reset();
  CHECK_FALSE(reduced(frame).sd_systematic[Quantity::v_td_mps].has_value());
}

TEST(BestEstimator, ACalibratedScaleReplacesTheBallsAndItsTolerance) {
  Frame frame = noisy();
  frame.ball_diameter_sd_m = 0.0008;
  frame.px_per_m = 4000.0;
  const Readout r = reduced(frame);
  // Speed no longer depends on the diameter but through the height of touchdown: the fall over 0.4 mm.
  CHECK_TRUE(*r.sd_systematic[Quantity::v_td_mps] < 1e-3);
  const Readout by_ball = reduced(noisy());
  CHECK_TRUE(*r.sd[Quantity::v_td_mps] < *by_ball.sd[Quantity::v_td_mps]);
  frame.px_per_m_sd = 8.0;  // 0.2 % against the ball's 0.24 %: together 0.154 %
  const Readout both = reduced(frame);
  CHECK_TRUE(*both.sd[Quantity::v_td_mps] > *r.sd[Quantity::v_td_mps]);
  CHECK_TRUE(*both.sd[Quantity::v_td_mps] < *by_ball.sd[Quantity::v_td_mps]);
}

TEST(BestEstimator, ABallOfUncertainSizeDoesNotOverruleABetterCalibratedScale) {
  // The ball is 1 % larger than what is stated, well within its tolerance of 1.2 %; its diameters are
  // measured to .04 %, the scale to .05 %.
  Frame frame = noisy();
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 2.0;
  for (BallImage& image : frame.images) image.diameter_sd_px = 0.1;
  const Readout as_stated = reduced(frame);
  frame.ball_diameter_sd_m = 0.0008;
  const Readout known = reduced(frame);
  for (BallImage& image : frame.images) image.diameter_px *= 1.01;
  const Readout larger = reduced(frame);
  for (const Quantity q : {Quantity::vx_td_mps, Quantity::vx_lo_mps}) {
    equal(*known.value[q], larger.value[q], 1e-9);
    equal(*known.sd[q], larger.sd[q], 1e-9);
    CHECK_TRUE(*known.sd[q] >= *as_stated.sd[q]);
    CHECK_TRUE(*larger.sd_systematic[q] < *larger.sd[q]);
  }
  // A scale that is less well known than the ball is told by both.
  frame.px_per_m_sd = 80.0;
  CHECK_TRUE(std::abs(*reduced(frame).value[Quantity::vx_td_mps] / *known.value[Quantity::vx_td_mps] - 1.0) >
             0.005);
}

TEST(BestEstimator, ACalibratedScaleWithoutAnSdIsExact) {
  // Diameters then say nothing: speeds have the same sd however well they are measured, and no tolerance of
  // the ball's.
  Frame frame = noisy();
  frame.px_per_m = 4000.0;
  frame.ball_diameter_sd_m = 0.0008;
  const Readout r = reduced(frame);
  for (BallImage& image : frame.images) image.diameter_px *= 1.05, image.diameter_sd_px = 1.0;
  const Readout other = reduced(frame);
  equal(*r.value[Quantity::vx_td_mps], other.value[Quantity::vx_td_mps]);
  equal(*r.sd[Quantity::vx_td_mps], other.sd[Quantity::vx_td_mps]);
  equal(0.0, r.sd_systematic[Quantity::vx_td_mps]);
  // An sd of 0 is none; a small one is nearly that.
  frame.px_per_m_sd = 0.0;
  equal(*r.value[Quantity::vx_td_mps], reduced(frame).value[Quantity::vx_td_mps]);
  frame.px_per_m_sd = 1e-5;
  equal(*r.value[Quantity::vx_td_mps], reduced(frame).value[Quantity::vx_td_mps], 1e-6);
  equal(*r.sd[Quantity::vx_td_mps], reduced(frame).sd[Quantity::vx_td_mps], 1e-6);
}

TEST(BestEstimator, PerImageNoiseOverridesTheFrames) {
  Frame frame = noisy();
  const Readout plain = reduced(frame);
  for (BallImage& i : frame.images) {
    i.centre_cov_px2 = std::array{4.0 * 4.0, 0.0, 0.0, 4.0 * 4.0};  // twice the frame's 2 px
    i.diameter_sd_px = 4.0;
    i.equator_sd_rad = 0.035;
  }
  const Readout wide = reduced(frame);
  equal(2.0 * *plain.sd[Quantity::omega_td_radps], wide.sd[Quantity::omega_td_radps], 1e-9);
  const double ratio = *wide.sd[Quantity::vx_td_mps] / *plain.sd[Quantity::vx_td_mps];
  CHECK_TRUE(ratio > 1.9 && ratio <= 2.0);  // the tilt's share stays
}

TEST(BestEstimator, AnImageThatIsOnlyGoodAcrossTheMotionIsWeightedSo) {
  Frame frame = noisy();
  for (BallImage& i : frame.images) i.centre_cov_px2 = std::array{400.0, 0.0, 0.0, 4.0};
  const Readout r = reduced(frame);
  const Readout plain = reduced(noisy());
  CHECK_TRUE(*r.sd[Quantity::vx_td_mps] > 5.0 * *plain.sd[Quantity::vx_td_mps]);
  DOUBLES_EQUAL(*plain.sd[Quantity::vy_td_mps], *r.sd[Quantity::vy_td_mps],
                0.15 * *plain.sd[Quantity::vy_td_mps]);
}

TEST(BestEstimator, TheCourtPaceNeedsATemperature) {
  Frame frame = noisy();
  CHECK_FALSE(reduced(frame).value[Quantity::court_pace].has_value());
  frame.record["temperature_c"] = "23.0";
  const Readout r = reduced(frame);
  const double expected = 100.0 * (1.0 - *r.value[Quantity::mu]) + 150.0 * (0.81 - *r.value[Quantity::e]);
  equal(expected, r.value[Quantity::court_pace]);
  CHECK_FALSE(r.court_pace_conforming);
  frame.record["temperature_c"] = "warm";
  CHECK_FALSE(reduced(frame).value[Quantity::court_pace].has_value());
}

TEST(BestEstimator, ACourtPaceConformsWithinTheFederationsLimits) {
  Bounce b;
  b.vx_td = 30.0 * std::cos(16.0 * kPi / 180), b.vy_td = -30.0 * std::sin(16.0 * kPi / 180),
  b.omega_td = 10.0;
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  test::Random random(1);
  Frame frame = test::photograph(b, setup, random);
  frame.temperature_c = 20.0;
  CHECK_TRUE(reduced(frame).court_pace_conforming);
  b.omega_td = 20.0;  // more than three turns a second
  frame = test::photograph(b, setup, random);
  frame.temperature_c = 20.0;
  CHECK_FALSE(reduced(frame).court_pace_conforming);
}

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
  frame.images[1].equator_rad = 0.1 - 0.2 + kPi;
  CHECK_TRUE(reduced(frame).regime == Regime::grips);
  // With backspin the slip is 18.25 m/s.
  frame.images[1].equator_rad = 0.1 + 0.2;
  frame.ball_alpha = 0.3;
  CHECK_TRUE(reduced(frame).regime == Regime::grips);  // needs 4.21
  frame.ball_alpha = 2.0 / 3.0;
  CHECK_TRUE(reduced(frame).regime == Regime::slides);  // needs 7.3
}

TEST(Regime21, WithinTwoSdItIsUnclear) {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  const Bounce b = test::thesis_bounces().front();  // 0.95 m/s short of rolling
  setup.centre_sd_m = 5e-3;
  test::Random random(1);
  CHECK_TRUE(reduced(test::photograph(b, setup, random)).regime == Regime::unclear);
}

TEST_GROUP(FrameChecks){};

TEST(FrameChecks, NameTheFieldThatIsWrong) {
  Frame frame = straight_frame();
  frame.ball_diameter_m = 0.0;
  STRCMP_CONTAINS("ball_diameter_m", complaint(frame).c_str());
  frame = straight_frame();
  frame.surface_px.resize(1);
  STRCMP_CONTAINS("surface_px: needs at least two points", complaint(frame).c_str());
  frame = straight_frame();
  frame.surface_px[2].y = std::nan("");
  STRCMP_CONTAINS("surface_px[2]", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[3].centre_px.x = INFINITY;
  STRCMP_CONTAINS("images[3].centre_px", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[1].diameter_px = 0.0;
  STRCMP_CONTAINS("images[1].diameter_px", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[1].time_s = 0.0;
  STRCMP_CONTAINS("images[1].time_s: must be later", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[4].centre_cov_px2 = std::array{1.0, 2.0, 2.0, 1.0};
  STRCMP_CONTAINS("images[4].centre_cov_px2: must be positive definite", complaint(frame).c_str());
  frame = straight_frame();
  frame.centre_sd_px = 0.0;
  STRCMP_CONTAINS("centre_sd_px", complaint(frame).c_str());
  frame = straight_frame();
  frame.surface_angle_deg = 100.0;
  STRCMP_CONTAINS("surface_angle_deg", complaint(frame).c_str());
}

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
    const auto r =
        reduce(frame, Estimator::best, {.effects = flight::Effects{}, .leave_out_outliers = false});
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

TEST(ReadoutFlags, AWrongEquatorOfFiveIsLeftOutAndTheFlightKept) {
  Frame frame = noisy();
  const Readout clean = reduced(frame);
  *frame.images[2].equator_rad += 0.8;
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::outlier_image));
  DOUBLES_EQUAL(2.61, *r.value[Quantity::omega_td_radps], 4.0 * *r.sd[Quantity::omega_td_radps]);
  equal(*clean.value[Quantity::vx_td_mps], r.value[Quantity::vx_td_mps]);
}

TEST(ReadoutFlags, CleanPhotographsHardlyEverLoseAnImage) {
  int lost = 0;
  test::Random random(11);
  constexpr int kShots = 4000;
  for (int i = 0; i < kShots; ++i) {
    const Readout r = reduced(test::photograph(Bounce{}, vacuum(), random));
    lost += r.flags.has(Flag::outlier_image) ? 1 : 0;
  }
  // Meant: one in a thousand, so 4 with a sd of 2.
  CHECK_TRUE(lost <= 12);
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
  const Readout r = reduced(test::photograph(b, vacuum(), random));
  CHECK_TRUE(*r.value[Quantity::omega_lo_radps] > 0.0);
  CHECK_TRUE(r.flags.has(Flag::spin_aliased));
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

TEST(ReadoutFlags, NoResidualsMeanNoSd) {
  Frame frame = straight_frame();
  frame.equator_sd_rad.reset();  // two equators a leg: no residual to know their noise from
  const Readout r = reduced(frame);
  CHECK_TRUE(r.value[Quantity::omega_td_radps].has_value());
  CHECK_FALSE(r.sd[Quantity::omega_td_radps].has_value());
  CHECK_FALSE(r.sd[Quantity::slip_lo_mps].has_value());
  CHECK_TRUE(r.sd[Quantity::vx_td_mps].has_value());
}
