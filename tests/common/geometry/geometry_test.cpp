// Lines and axes against figures worked out by hand.
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/geometry/leg.hpp"
#include "common/geometry/leg_classification.hpp"
#include "common/geometry/line.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::geometry;
using Eigen::Vector2d;

namespace {

constexpr double kRounding = 1e-14;

void equal(const Vector2d& expected, const Vector2d& actual, double tolerance = kRounding) {
  DOUBLES_EQUAL(expected.x(), actual.x(), tolerance);
  DOUBLES_EQUAL(expected.y(), actual.y(), tolerance);
}

}  // namespace

TEST_GROUP(Rotations){};

TEST(Rotations, TurnCounterClockwiseAndBack) {
  equal({0.0, 1.0}, Rotation2d(std::numbers::pi / 2) * Vector2d(1.0, 0.0));
  const Rotation2d rotation(0.3);
  equal({2.0, -5.0}, rotation.inverse() * (rotation * Vector2d(2.0, -5.0)));
  equal({2.0, -5.0}, Rotation2d() * Vector2d(2.0, -5.0));
}

TEST_GROUP(LineFits){};

TEST(LineFits, GoThroughPointsOfALineWhateverItsTilt) {
  for (const double tilt : {-1.5, -0.4, 0.0, 0.7, 1.5}) {
    const Vector2d along(std::cos(tilt), std::sin(tilt));
    const std::vector<Vector2d> points{Vector2d(3.0, 4.0) - 2.0 * along, Vector2d(3.0, 4.0) + 5.0 * along,
                                       Vector2d(3.0, 4.0) + 6.0 * along};
    const auto line = fit_line(points);
    CHECK_TRUE(line.has_value());
    equal(along, line->direction());
    equal(Vector2d(3.0, 4.0) + 3.0 * along, line->origin());
    equal({7.0, 2.0},
          line->coordinates(line->origin() + 7.0 * along + 2.0 * Vector2d(-along.y(), along.x())));
  }
}

TEST(LineFits, MinimizeTheDistanceNotTheHeight) {
  // Scatter matrix [[8, 4], [4, 2 + 2/3 ...]]: its main axis, tan 2a = 2 sxy / (sxx - syy).
  const std::array<Vector2d, 3> points{Vector2d(0.0, 0.0), Vector2d(2.0, 2.0), Vector2d(4.0, 1.0)};
  // About the mean (2, 1): sxx = 8, sxy = 2, syy = 2.
  const auto line = fit_line(points);
  DOUBLES_EQUAL(0.5 * std::atan2(4.0, 6.0), std::atan2(line->direction().y(), line->direction().x()),
                kRounding);
}

TEST(LineFits, WeighAPointAsManyTimesAsItsWeightSays) {
  const std::array<Vector2d, 3> points{Vector2d(0.0, 0.0), Vector2d(2.0, 2.0), Vector2d(4.0, 1.0)};
  const std::array<Vector2d, 4> twice{points[0], points[1], points[1], points[2]};
  const auto weighted = fit_line(points, std::array{0.5, 1.0, 0.5});
  const auto repeated = fit_line(twice);
  equal(repeated->origin(), weighted->origin());
  equal(repeated->direction(), weighted->direction());
}

TEST(LineFits, KeepTheirDigitsFarFromTheOrigin) {
  const std::array<Vector2d, 2> near{Vector2d(0.0, 0.0), Vector2d(3.0, 1.0)};
  const std::array<Vector2d, 2> far{Vector2d(1e12, -1e12), Vector2d(1e12 + 3.0, -1e12 + 1.0)};
  equal(fit_line(near)->direction(), fit_line(far)->direction());
  equal(fit_line(near)->coordinates(near[1]), fit_line(far)->coordinates(far[1]));
}

TEST(LineFits, OfOnePointAreNone) {
  CHECK_FALSE(fit_line({}).has_value());
  const std::array<Vector2d, 2> same{Vector2d(1.0, 2.0), Vector2d(1.0, 2.0)};
  CHECK_FALSE(fit_line(same).has_value());
  // About their mean the two are 1.5 and 1.5 away: root of the sum of squares 2.12.
  const std::array<Vector2d, 2> apart{Vector2d(0.0, 0.0), Vector2d(3.0, 0.0)};
  CHECK_TRUE(fit_line(apart, {}, 2.12).has_value());
  CHECK_FALSE(fit_line(apart, {}, 2.13).has_value());
  const std::array<Vector2d, 2> nowhere{Vector2d(0.0, 0.0), Vector2d(std::nan(""), 0.0)};
  CHECK_FALSE(fit_line(nowhere).has_value());
}

TEST_GROUP(Regressions){};

TEST(Regressions, GiveMeanSlopeAndTheirVariances) {
  // x 0, 1, 3 with weights 1, 2, 1: mean 1.25, moment 4.75; values 1, 3, 6: mean 3.25, slope 7.75/4.75.
  LinearRegression<double> line;
  line.add(0.0, 1.0, 1.0);
  line.add(1.0, 3.0, 2.0);
  line.add(3.0, 6.0, 1.0);
  DOUBLES_EQUAL(4.0, line.weight(), kRounding);
  DOUBLES_EQUAL(1.25, line.mean_x(), kRounding);
  DOUBLES_EQUAL(3.25, line.mean(), kRounding);
  DOUBLES_EQUAL(4.75, line.moment(), kRounding);
  DOUBLES_EQUAL(7.75 / 4.75, line.slope(), kRounding);
  DOUBLES_EQUAL(3.25 - 1.25 * 7.75 / 4.75, line.at(0.0), kRounding);
  DOUBLES_EQUAL(1.0 / 4.75, line.slope_variance(), kRounding);
  DOUBLES_EQUAL(0.25 + 1.25 * 1.25 / 4.75, line.variance_at(0.0), kRounding);
}

TEST(Regressions, OfVectorsAreThoseOfTheirComponents) {
  LinearRegression<Vector2d> both;
  LinearRegression<double> y;
  for (int i = 0; i < 5; ++i) {
    both.add(i, {1.0 + 2.0 * i, std::sin(i)}, 1.0 + i);
    y.add(i, std::sin(i), 1.0 + i);
  }
  equal({2.0, y.slope()}, both.slope());
  equal({1.0 + 2.0 * 7.0, y.at(7.0)}, both.at(7.0));
}

TEST(Regressions, KeepALightSampleBesideAHeavyOne) {
  // A weight of 1e20 beside 1: the moment about the mean, 1e20 / (1e20 + 1), is the light one's, all its digits.
  LinearRegression<double> line;
  line.add(0.0, 0.0, 1e20);
  line.add(1.0, 2.0, 1.0);
  DOUBLES_EQUAL(1.0, line.moment(), kRounding);
  DOUBLES_EQUAL(2.0, line.slope(), kRounding);
}

TEST_GROUP(SurfaceFrames){};

TEST(SurfaceFrames, MeasureAlongAndUpFromTheSurface) {
  const double tilt = 0.1;
  const Vector2d along(std::cos(tilt), std::sin(tilt));
  const Vector2d up(-along.y(), along.x());
  const std::array<Vector2d, 2> points{Vector2d(100.0, 50.0), Vector2d(100.0, 50.0) + 200.0 * along};
  SurfaceFrame frame{.line = *fit_line(points), .px_per_unit = 4.0};
  const Vector2d ball = points[0] + 140.0 * along + 60.0 * up;
  equal({10.0, 15.0}, frame.from_image(ball), 1e-12);
  equal({40.0, 60.0}, SurfaceFrame{.line = frame.line}.from_image(ball), 1e-12);
  equal(ball, frame.to_image({10.0, 15.0}), 1e-12);
  frame.mirrored = true;
  equal({-10.0, 15.0}, frame.from_image(ball), 1e-12);
  equal(ball, frame.to_image({-10.0, 15.0}), 1e-12);
}

// A leg's flight through its images, and where it meets the surface.
using namespace strobe;

namespace {

/// Falls from 1 m at (15, -6) m/s under a strong pull, so that its sign shows.
const flight::Parabola kFalling{Vector2d(0.2, 1.0), Vector2d(15.0, -6.0), Vector2d(-20.0, -60.0)};

LegFit fitted(const flight::Parabola& path, double first_s) {
  LegFit fit(path.acceleration);
  for (const double t : {0.0, 0.01, 0.04}) fit.add(first_s + t, path.position_at(t));
  return fit;
}

}  // namespace

TEST_GROUP(LegFits){};

TEST(LegFits, RecoverAnExactFlight) {
  const LegFit fit = fitted(kFalling, 5.0);
  LONGS_EQUAL(3, fit.count());
  // The mean of 0, 0.01 and 0.04. Rounding of times near 5 s: 1e-15 of them, times 15 m/s.
  DOUBLES_EQUAL(5.0 + 0.05 / 3.0, fit.mean_time_s(), 1e-14);
  const flight::Parabola path = fit.path();
  const double t = 0.05 / 3.0;
  DOUBLES_EQUAL(0.0, (path.position - kFalling.position_at(t)).norm(), 1e-13);
  DOUBLES_EQUAL(0.0, (path.velocity - kFalling.velocity_at(t)).norm(), 1e-12);
  DOUBLES_EQUAL(0.0, (path.acceleration - kFalling.acceleration).norm(), 0.0);
}

TEST(LegFits, KnowTheirVariances) {
  const LegFit fit = fitted(kFalling, 0.0);
  // Times about their mean: -1/60, -1/150, 7/300; squares add to 8.6667e-4.
  DOUBLES_EQUAL(1.0 / 8.666666666666667e-4, fit.velocity_variance(), 1e-9);
  DOUBLES_EQUAL(1.0 / 3.0 + 0.04 * 0.04 / 8.666666666666667e-4, fit.position_variance(0.05 / 3.0 + 0.04),
                1e-12);
}

TEST(LegFits, NeedTwoInstantsForAVelocity) {
  LegFit fit(Vector2d(0.0, -9.8));
  CHECK_FALSE(fit.has_velocity());
  fit.add(1.0, {0.0, 0.0});
  CHECK_FALSE(fit.has_velocity());
  CHECK_FALSE(crossing(fit, 0.0, fit.mean_time_s()).has_value());
  fit.add(2.0, {1.0, 1.0});
  CHECK_TRUE(fit.has_velocity());
}

TEST_GROUP(Crossings){};

TEST(Crossings, AreWhereTheFlightIsAtTheHeight) {
  // 1 - 6 t - 30 t² = 0.1 at t = 0.1 (1 - 0.6 - 0.3).
  const LegFit fit = fitted(kFalling, 5.0);
  const auto down = crossing(fit, 0.1, fit.mean_time_s());
  CHECK_TRUE(down.has_value());
  DOUBLES_EQUAL(5.1, down->time_s, 1e-13);
  DOUBLES_EQUAL(0.2 + 1.5 - 0.1, down->position.x(), 1e-12);
  DOUBLES_EQUAL(0.1, down->position.y(), 1e-12);
  DOUBLES_EQUAL(15.0 - 2.0, down->velocity.x(), 1e-11);
  DOUBLES_EQUAL(-12.0, down->velocity.y(), 1e-11);
}

TEST(Crossings, OfARisingLegAreBeforeIt) {
  // Lift-off at t = 0 from 0.03 at 5 m/s; images from 10 ms on.
  const flight::Parabola rising{Vector2d(0.0, 0.03), Vector2d(9.0, 5.0), Vector2d(0.0, -60.0)};
  LegFit fit(rising.acceleration);
  for (const double t : {0.01, 0.02, 0.04}) fit.add(t, rising.position_at(t));
  const auto up = crossing(fit, 0.03, fit.mean_time_s());
  DOUBLES_EQUAL(0.0, up->time_s, 1e-14);
  DOUBLES_EQUAL(5.0, up->velocity.y(), 1e-12);
  CHECK_FALSE(crossing(fit, 0.03 + 25.0 / 120.0 + 1e-6, fit.mean_time_s()).has_value());  // above the apex
}

TEST(Crossings, OfALegBetweenTwoBouncesAreTheOneBesideTheImage) {
  // Off at t = 0 from 0.03 at 5 m/s, down again 10/60 s later.
  const flight::Parabola arc{Vector2d(0.0, 0.03), Vector2d(9.0, 5.0), Vector2d(0.0, -60.0)};
  LegFit fit(arc.acceleration);
  for (const double t : {0.01, 0.07, 0.12, 0.15}) fit.add(t, arc.position_at(t));
  DOUBLES_EQUAL(0.0, crossing(fit, 0.03, 0.01)->time_s, 1e-14);
  const auto down = crossing(fit, 0.03, 0.15);
  DOUBLES_EQUAL(10.0 / 60.0, down->time_s, 1e-14);
  DOUBLES_EQUAL(-5.0, down->velocity.y(), 1e-12);
}

TEST(Crossings, OfALegAlongTheSurfaceAreNone) {
  LegFit level(Vector2d::Zero());
  level.add(0.0, {0.0, 1.0});
  level.add(1.0, {1.0, 1.0});
  CHECK_FALSE(crossing(level, 1.0, level.mean_time_s()).has_value());
}

using strobe::Leg;

namespace {

constexpr double kGravity = -9.80665;
constexpr double kVariance = 0.25e-6;  // half a millimetre

std::string word(const std::vector<Leg>& legs) {
  std::string text;
  for (const Leg leg : legs) text += leg == Leg::incoming ? 'i' : leg == Leg::contact ? 'c' : 'r';
  return text;
}

/// Lower edge of a ball at -6 m/s, 4 ms in contact, 5 m/s after; flashes every 3 ms; touchdown at time 0.
std::vector<TimedHeight> bounce(double first_flash_s, int flashes) {
  std::vector<TimedHeight> heights;
  for (int i = 0; i < flashes; ++i) {
    const double t = first_flash_s + i * 3e-3, free = t < 0 ? -6.0 * t : 5.0 * (t - 4e-3);
    const double height = t >= 0 && t <= 4e-3 ? -0.006 : free + 0.5 * kGravity * t * t;
    heights.push_back({t, height, kVariance, std::nullopt});
  }
  return heights;
}

LegAssignment find_with(std::vector<TimedHeight> heights, double reference_variance) {
  for (TimedHeight& image : heights) image.reference_variance_m2 = reference_variance;
  return classify_timed(heights, kGravity);
}
LegAssignment find(const std::vector<TimedHeight>& heights) { return find_with(heights, kVariance); }

}  // namespace

TEST_GROUP(TimedLegs){};

TEST(TimedLegs, FindsFlightContactAndFlight) {
  CHECK_EQUAL("iiiicrrr", word(find(bounce(-10e-3, 8)).legs));     // flashes at -1 and 2 ms
  CHECK_EQUAL("iiiiccrrr", word(find(bounce(-11.5e-3, 9)).legs));  // at 0.5 and 3.5 ms
}

TEST(TimedLegs, ABounceBetweenTwoFlashesHasNoContactImage) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  heights.erase(heights.begin() + 4);
  CHECK_EQUAL("iiiirrr", word(find(heights).legs));
}

TEST(TimedLegs, JudgesAnImageAtTheSurfaceByItsTimeNotByItsHeight) {
  // The image 0.1 ms before touchdown is 0.6 mm above the surface. Two sd of noise either way change nothing.
  for (const double noise : {-1e-3, 1e-3}) {
    std::vector<TimedHeight> before = bounce(-9.1e-3, 7);
    before[3].height_m += noise;
    CHECK_EQUAL("iiiicrr", word(find(before).legs).substr(0, 7));
    std::vector<TimedHeight> after = bounce(-8.9e-3, 7);  // 0.1 ms after touchdown: -0.6 mm if it were flight
    after[3].height_m = -0.6e-3 + noise;
    CHECK_EQUAL("iiiccrr", word(find(after).legs));
  }
}

TEST(TimedLegs, AnImagePressedIntoTheSurfaceIsInContactThoughItsTimeIsWithinTheLeg) {
  // Drag and lift of 5 m/s^2, of which the path's prediction knows nothing: over 57 ms it reaches the surface
  // 5 · 0.057^2 / 12 m = 1.4 mm too high, 0.27 ms too early. 0.1 ms before lift-off the ball is 0.5 mm deep, 35 sd.
  constexpr double kFine = 1e-10;  // 10 micrometres
  std::vector<TimedHeight> heights{{-3.1e-3, -0.01, kFine, std::nullopt},
                                   {-0.1e-3, -0.5e-3, kFine, std::nullopt}};
  for (int i = 0; i < 20; ++i) {
    const double t = 2.9e-3 + i * 3e-3;
    heights.push_back({t, 5.0 * t + 0.5 * (kGravity - 5.0) * t * t, kFine, std::nullopt});
  }
  CHECK_EQUAL("cc" + std::string(20, 'r'), word(find_with(heights, kFine).legs));
}

TEST(TimedLegs, KeepsLabels) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  heights[5].leg = Leg::contact;
  CHECK_EQUAL("iiiiccrr", word(find(heights).legs));
}

TEST(TimedLegs, LeavesOutAnOverlappingImageThatIsLabelledAirborne) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i].leg = i < 5 ? Leg::incoming : Leg::rebound;
  const LegAssignment found = find(heights);
  CHECK_EQUAL("iiiicrrr", word(found.legs));
  LONGS_EQUAL(1, found.overlaps.size());
  LONGS_EQUAL(4, found.overlaps[0]);
}

TEST(TimedLegs, AnImageInContactButWithinNoiseIsNotAnOverlap) {
  std::vector<TimedHeight> heights = bounce(-8.9e-3, 7);
  heights[3].height_m = -0.6e-3;
  for (std::size_t i = 0; i < heights.size(); ++i)
    heights[i].leg = i < 4 ? Leg::incoming : i == 4 ? Leg::contact : Leg::rebound;
  CHECK_TRUE(find(heights).overlaps.empty());
}

// A leg at 0.3 m/s. Four images, 3 ms apart, tell the height 3 ms before them to 0.5 mm sqrt(1/4 + 7.5^2/45) = 0.61 mm,
// with the reference's 0.5 mm to 0.79 mm: 2.2 mm are 2.8 sd, 2.7 mm 3.4 sd. At the time when they have it at the surface
// they tell it better, by which 2.2 mm would be 3.9 sd.
TEST(TimedLegs, OfASlowLegTheImageNextToTheSurfaceIsHeldAgainstThePathAtItsOwnTime) {
  constexpr double kRise = 0.3;
  const auto rebound = [&](double lowest_m) {
    std::vector<TimedHeight> heights{{-10e-3, 0.06, kVariance, Leg::incoming, 0.0},
                                     {-7e-3, 0.03, kVariance, Leg::incoming, 0.0},
                                     {-3e-3, -0.01, kVariance, Leg::contact, 0.0}};
    for (int i = 0; i < 5; ++i) {
      const double t = i * 3e-3;
      heights.push_back({t, i == 0 ? lowest_m : lowest_m + kRise * t, kVariance, Leg::rebound, 0.0});
    }
    for (TimedHeight& h : heights) h.reference_variance_m2 = kVariance;
    return classify_timed(heights, 0.0).overlaps.size();
  };
  LONGS_EQUAL(0, rebound(-2.2e-3));
  LONGS_EQUAL(1, rebound(-2.7e-3));
}

TEST(TimedLegs, ASurfaceThatIsNotKnownThereMakesNoOverlap) {
  std::vector<TimedHeight> heights = bounce(-10e-3, 8);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i].leg = i < 5 ? Leg::incoming : Leg::rebound;
  heights[4].reference_variance_m2 = 36.0 * 36e-6;  // 36 mm, of an image 6 mm deep whose path says 12
  CHECK_TRUE(classify_timed(heights, kGravity).overlaps.empty());
  heights[4].reference_variance_m2 = kVariance;
  LONGS_EQUAL(1, classify_timed(heights, kGravity).overlaps.size());
}

TEST(TimedLegs, TakesWhatThereIs) {
  CHECK_TRUE(find({}).legs.empty());
  CHECK_EQUAL("c", word(find({{0.0, -0.001, kVariance, std::nullopt, 0.0}}).legs));
  const std::vector<TimedHeight> falling = bounce(-10e-3, 3);
  LONGS_EQUAL(3, find(falling).legs.size());
}

TEST(TimedLegs, KnowWhichWayGravityPulls) {
  // A slow ball, 20 ms between flashes: falling from rest at 5 cm, the next image is at 0.1 s, 4.9 cm below,
  // 1 mm above the surface. Without the fall it would be judged far above it; with the fall counted upwards, too.
  const auto slow = [](double last_s) {
    std::vector<TimedHeight> heights;
    for (const double t : {0.0, 0.03, 0.06, last_s})
      heights.push_back({t, 0.0441 + 0.5 * kGravity * t * t, 1e-8, std::nullopt});
    heights.back().height_m = 1e-5;  // within noise of the surface: only its time tells
    return heights;
  };
  // 0.0441 m are fallen in 94.8 ms.
  CHECK_EQUAL("iiii", word(find_with(slow(0.0945), 1e-8).legs));
  CHECK_EQUAL("iiic", word(find_with(slow(0.0952), 1e-8).legs));
}

TEST_GROUP(UntimedLegs) {
  using Centres = std::vector<Eigen::Vector2d>;
  static std::string legs(const Centres& centres, std::vector<std::optional<Leg>> labels = {},
                          double contact_height = 0.9) {
    labels.resize(centres.size());
    return word(classify_untimed(centres, labels, contact_height));
  }
};

TEST(UntimedLegs, ChangeAtTheLowestImage) {
  CHECK_EQUAL("", legs({}));
  CHECK_EQUAL("i", legs({{0, 2}}));
  CHECK_EQUAL("iicrr", legs({{0, 3}, {1, 2}, {2, 0.5}, {3, 2}, {4, 3}}));
  CHECK_EQUAL("iiccrr", legs({{0, 3}, {1, 2}, {2, 0.5}, {3, 0.8}, {4, 2}, {5, 3}}));
}

TEST(UntimedLegs, GiveALowestImageInTheAirToTheLegOnWhoseLineItIs) {
  CHECK_EQUAL("iiirr", legs({{0, 3}, {1, 2}, {2, 1}, {4, 1.5}, {6, 2.5}}));
  CHECK_EQUAL("iirrr", legs({{0, 3}, {1, 1.5}, {3, 1}, {4, 2}, {5, 3}}));
  CHECK_EQUAL("rrr", legs({{0, 1}, {1, 2}, {2, 3}}));
  CHECK_EQUAL("iii", legs({{0, 3}, {1, 2}, {2, 1}}));
  CHECK_EQUAL("ir", legs({{0, 1}, {1, 2}}, {Leg::incoming}));
}

TEST(UntimedLegs, KeepLabelsExceptOfImagesThatTouch) {
  CHECK_EQUAL("iiirr", legs({{0, 3}, {1, 2}, {2, 1}, {3, 0.95}, {4, 2}},
                            {std::nullopt, std::nullopt, std::nullopt, Leg::rebound, std::nullopt}));
  CHECK_EQUAL("iicrr", legs({{0, 3}, {1, 2}, {2, 0.5}, {3, 2}, {4, 3}}, {{}, {}, Leg::incoming, {}, {}}));
}

TEST(UntimedLegs, FollowEachOther) {
  CHECK_EQUAL("icccr", legs({{0, 3}, {1, 2}, {2, 1}, {3, 2}, {4, 3}},
                            {Leg::incoming, Leg::rebound, Leg::incoming, Leg::incoming, Leg::rebound}));
}
