// What the best estimator gets from plain photographs: exact where they are, with sds as noise is stated.
#include <array>
#include <cmath>
#include <numbers>

#include "tests/common/reduction/reduced_frames.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

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
  drop.vx_lo = 0.08, drop.vy_lo = 0.55, drop.omega_lo = -1.5, drop.dwell_x_m = 0.0005;
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  setup.period_s = 0.01;
  test::Random random(1);
  const Readout r = reduced(test::photograph(drop, setup, random));
  equal(0.1, r.value[Quantity::vx_td_mps], 1e-9);
  equal(0.55, r.value[Quantity::e], 1e-9);
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
  // Centres that are better known across one diagonal of the photograph than across the other.
  const auto with_covariance = [](Frame frame, double xy) {
    for (std::size_t i = 0; i < frame.images.size(); i += 2)
      frame.images[i].centre_cov_px2 = std::array{9.0, xy, xy, 4.0};
    return frame;
  };
  const Readout right = reduced(with_covariance(noisy(setup), 5.0));
  setup.mirror = true;
  const Readout left = reduced(with_covariance(noisy(setup), -5.0));
  CHECK_FALSE(right.mirrored);
  CHECK_TRUE(left.mirrored);
  for (std::size_t i = 0; i + 1 < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    equal(*right.value[q], left.value[q], 1e-9 * std::max(1.0, std::abs(*right.value[q])));
    equal(*right.sd[q], left.sd[q], 1e-9);
  }
}

TEST(BestEstimator, AnImageThatIsLeftOutDoesNotDecideTheDirectionOfTravel) {
  // Steep: 0.18 m along the surface in five images, less than the first one is off.
  for (const bool to_the_left : {false, true}) {
    Setup setup = vacuum();
    setup.mirror = to_the_left;
    Bounce steep;
    steep.vx_td = 5.0, steep.vy_td = -12.0, steep.vx_lo = 4.0, steep.vy_lo = 9.0;
    Random random(5);
    Frame frame = photograph(steep, setup, random);
    frame.images.front().centre_px.x += to_the_left ? -900.0 : 900.0;
    const Readout r = reduced(frame);
    CHECK_TRUE(r.flags.has(Flag::outlier_image));
    CHECK_EQUAL(to_the_left, r.mirrored);
    for (const Quantity q :
         {Quantity::vx_td_mps, Quantity::vx_lo_mps, Quantity::omega_td_radps, Quantity::omega_lo_radps})
      DOUBLES_EQUAL(*truth(steep)[q], *r.value[q], 5.0 * *r.sd[q]);
  }
}

TEST(BestEstimator, LegsThatNobodyNamedAreFoundUnderGravity) {
  // A slow ball, 10 ms between flashes, 0.3 ms and half a millimetre past touchdown at one of them: only the
  // fall of the others, 2 mm within a leg, tells that it is in contact.
  Bounce drop;
  drop.vx_td = 0.6, drop.vy_td = -1.0, drop.omega_td = 0.0;
  drop.vx_lo = 0.5, drop.vy_lo = 0.75, drop.omega_lo = -1.5, drop.dwell_x_m = 0.003;
  Setup setup = vacuum();
  setup.period_s = 0.01;
  setup.phase = 0.97;
  setup.noise_factor = 0.0;
  test::Random random(1);
  Frame frame = test::photograph(drop, setup, random);
  const Readout labelled = reduced(frame);
  for (BallImage& image : frame.images) image.leg.reset();
  const Readout found = reduced(frame);
  CHECK_EQUAL(labelled.flags, found.flags);
  equal(*labelled.value[Quantity::vy_td_mps], found.value[Quantity::vy_td_mps]);
  equal(*labelled.sd[Quantity::vy_td_mps], found.sd[Quantity::vy_td_mps]);
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
  Setup setup = vacuum();
  setup.diameter_sd_m = 0.1 / setup.px_per_m;
  Frame frame = noisy(setup);
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 2.0;
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
  // A scale that is less well known than the ball follows from both.
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

TEST(BestEstimator, AnImagesCovarianceTurnsWithThePhotograph) {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  const auto sds = [&](double roll_rad) {  // 20 px along the surface, 2 px across
    setup.roll_rad = roll_rad;
    Frame frame = noisy(setup);
    const double cos = std::cos(roll_rad), sin = std::sin(roll_rad), xy = (400.0 - 4.0) * cos * sin;
    for (BallImage& i : frame.images)
      i.centre_cov_px2 =
          std::array{400.0 * cos * cos + 4.0 * sin * sin, xy, xy, 400.0 * sin * sin + 4.0 * cos * cos};
    return reduced(frame).sd;
  };
  const Quantities level = sds(0.0);
  for (const double roll_rad : {-1.2, 0.4, 0.8}) {
    const Quantities turned = sds(roll_rad);
    for (std::size_t i = 0; i + 1 < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      // Rounding, beside variances of which one is a hundredth of the other.
      equal(*level[q], turned[q], 1e-9 * *level[q]);
    }
  }
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
  b.vx_lo = 23.0;  // friction turns the ball by as much as it takes from its travel
  b.vx_td = 30.0 * std::cos(16.0 * std::numbers::pi / 180),
  b.vy_td = -30.0 * std::sin(16.0 * std::numbers::pi / 180), b.omega_td = 10.0;
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

// The numbers from two images a leg, worked out by hand in the comments.

TEST_GROUP(TwoPoint){};

TEST(TwoPoint, GivesTheNumbersWorkedOutByHand) {
  Frame frame = straight_frame();
  frame.temperature_c = 13.0;
  const Readout r = reduced(frame, Estimator::two_point);
  LONGS_EQUAL(7, r.shot_id);
  CHECK_EQUAL("two-point", r.method);
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
  BallImage far = ball_image(-2, Leg::incoming, 70, 190, 2.0);
  frame.images.insert(frame.images.begin(), far);
  const Readout r = reduced(frame, Estimator::two_point);
  equal(15.0, r.value[Quantity::vx_td_mps]);
  equal(-100.0, r.value[Quantity::omega_td_radps]);
}

TEST_GROUP(FrameChecks){};

TEST(FrameChecks, NameTheFieldThatIsWrong) {
  struct Row {
    const char* complaint;
    void (*change)(Frame& frame);
  };
  const Row rows[] = {
      {"ball_diameter_m: must be from 0.01 to 1", [](Frame& f) { f.ball_diameter_m = 0.0; }},
      {"surface_px: needs at least two points", [](Frame& f) { f.surface_px.resize(1); }},
      {"surface_px[2]: must be two numbers from -1e12 to 1e12",
       [](Frame& f) { f.surface_px[2].y = std::nan(""); }},
      {"images[3].centre_px: must be two numbers from -1e12 to 1e12",
       [](Frame& f) { f.images[3].centre_px.x = INFINITY; }},
      {"images[1].diameter_px: must be from 1e-9 to 1e12",
       [](Frame& f) { f.images[1].diameter_px = 0.0; }},
      {"images[1].time_s: must be later than the image before, by a nanosecond or more",
       [](Frame& f) { f.images[1].time_s = 0.0; }},
      {"images[4].centre_cov_px2: must be positive definite",
       [](Frame& f) {
         f.images[4].centre_cov_px2 = std::array{1.0, 2.0, 2.0, 1.0};
       }},
      {"images[4].centre_cov_px2: must be symmetric",
       [](Frame& f) {
         f.images[4].centre_cov_px2 = std::array{2.0, 1.0, 1.0 + 1e-5, 1.0};
       }},
      {"",  // rounding of printed numbers
       [](Frame& f) {
         f.images[4].centre_cov_px2 = std::array{1.0, 0.99, 0.99 + 1e-7, 1.0};
       }},
      {"centre_sd_px: must be from 1e-9 to 1e12",
       [](Frame& f) { f.centre_sd_px = 0.0; }},
      {"ball_alpha_sd: must be from 0 to 2/3", [](Frame& f) { f.ball_alpha_sd = -0.01; }},
      {"surface_angle_deg: must be from -90 to 90", [](Frame& f) { f.surface_angle_deg = 100.0; }},
      {"images[2].equator_sd_rad: must be from 1e-9 to 1e6",
       [](Frame& f) { f.images[2].equator_sd_rad = 0.0; }},
      {"images[1].probability: must be above 0, and not above 1",
       [](Frame& f) { f.images[1].probability = 0.0; }},
      {"images[3].probability: must be above 0, and not above 1",
       [](Frame& f) { f.images[3].probability = 1.0 + 1e-12; }},
      {"images[3].probability: must be above 0, and not above 1",
       [](Frame& f) { f.images[3].probability = std::nan(""); }},
  };
  for (const Row& row : rows) {
    Frame frame = straight_frame();
    row.change(frame);
    STRCMP_EQUAL(row.complaint, complaint(frame).c_str());
  }
}
