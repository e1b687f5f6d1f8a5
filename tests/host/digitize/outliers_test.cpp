// The size that the images of one ball agree on, against sizes that are known.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "host/digitize/outliers/ball_odds.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"
#include "host/digitize/outliers/selection.hpp"
#include "tests/host/digitize/painter.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;

Outline ball_at(double x, double diameter, double sd = 0.1) {
  Outline outline;
  outline.centre = {x, 400.0};
  outline.diameter = diameter;
  outline.covariance = cv::Matx33d::eye() * (sd * sd);
  return outline;
}

/// Seven balls 300 px apart, the diameter growing by `slope` per px of x.
std::vector<Outline> row(double slope) {
  std::vector<Outline> outlines;
  for (int k = 0; k < 7; ++k) outlines.push_back(ball_at(100.0 + 300.0 * k, 260.0 + slope * 300.0 * k));
  return outlines;
}

}  // namespace

TEST_GROUP(BallSize){};

TEST(BallSize, IsTheMedianDiameterWhateverOneOutlierIs) {
  auto outlines = row(0.0);
  outlines[2].diameter = 300.0;
  const SizeModel size = fit_size_model(outlines);
  DOUBLES_EQUAL(260.0, size.at(100.0), 1e-9);
  DOUBLES_EQUAL(260.0, size.at(1900.0), 1e-9);
}

TEST(BallSize, FollowsASteadyChangeAcrossThePhotographDespiteAnOutlier) {
  auto outlines = row(-0.004);
  outlines[4].diameter += 20.0;
  const SizeModel size = fit_size_model(outlines);
  for (const int k : {0, 3, 6}) DOUBLES_EQUAL(260.0 - 1.2 * k, size.at(100.0 + 300.0 * k), 1e-9);
}

TEST(BallSize, OfFewBallsHasNoSlope) {
  const std::vector<Outline> few{ball_at(100.0, 258.0), ball_at(700.0, 260.0), ball_at(1300.0, 262.0),
                                 ball_at(1900.0, 264.0)};
  const SizeModel size = fit_size_model(few);
  DOUBLES_EQUAL(0.0, size.slope, 0.0);
  DOUBLES_EQUAL(261.0, size.diameter, 1e-9);
}

TEST(BallSize, HasTheSdOfAMedian) {
  // Alike: each outline's own sd. A median of n normal errors has sqrt(pi/2) = 1.2533 of the mean's sd.
  const SizeModel alike = fit_size_model(row(0.0));
  DOUBLES_EQUAL(0.1 * std::sqrt(M_PI / 2.0) / std::sqrt(7.0), alike.sd, 1e-3 * alike.sd + 2e-4);
  // Differences beyond that: by the median deviation, 1.4826 times which is a normal distribution's sd.
  auto apart = row(0.0);
  const std::array off{-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0};
  const std::array shuffle{3, 0, 6, 2, 5, 1, 4};  // no trend along x
  for (std::size_t k = 0; k < off.size(); ++k) apart[static_cast<std::size_t>(shuffle[k])].diameter += off[k];
  DOUBLES_EQUAL(1.4826 * 2.0 * std::sqrt(M_PI / 2.0) / std::sqrt(7.0), fit_size_model(apart).sd, 0.01);
}

TEST(BallSize, ThatDiffersFromBallToBallHasASpreadBesideTheOutlinesOwnSd) {
  DOUBLES_EQUAL(0.0, fit_size_model(row(0.0)).spread, 0.0);
  // Where the path comes nearer and goes away again: no slope, and a median deviation of 8 px.
  auto bent = row(0.0);
  const std::array more{-12.0, -8.0, 0.0, 12.0, 8.0, 0.0, -8.0};
  for (std::size_t k = 0; k < more.size(); ++k) bent[k].diameter += more[k];
  const SizeModel size = fit_size_model(bent);
  DOUBLES_EQUAL(1.4826 * 8.0, size.spread, 0.01);
  for (const Outline& outline : bent) CHECK_TRUE(log_odds_of_size(outline, size) > 0.0);
}

TEST(BallSize, SpeaksForABallAsFarAsBothAreKnown) {
  const SizeModel size{260.0, 0.0, 0.3};
  const double sure = log_odds_of_size(ball_at(0.0, 260.0), size);
  CHECK_TRUE(sure > 0.0);
  CHECK_TRUE(log_odds_of_size(ball_at(0.0, 260.0, 20.0), size) < sure);
  // An outline of which the size is hardly known is hardly of another one.
  CHECK_TRUE(log_odds_of_size(ball_at(0.0, 290.0, 20.0), size) > log_odds_of_size(ball_at(0.0, 290.0), size));
  DOUBLES_EQUAL(log_odds_of_size(ball_at(0.0, 250.0), size), log_odds_of_size(ball_at(0.0, 270.0), size), 1e-9);
}

namespace {

struct Row {
  std::vector<PathPoint> points;
  std::vector<double> quality;
  Path path;

  void add(double x, double m) {
    if (path.legs.empty()) path.legs.emplace_back();
    path.legs[0].push_back(static_cast<int>(points.size()));
    points.push_back({{x, 2000.0 - x}, 0.1, 1.0});
    quality.push_back(m);
  }
};

/// Even steps of 100 px, and one image more.
Row row(double more_at, double quality) {
  Row r;
  for (int k = 0; k < 8; ++k) {
    r.add(100.0 * k, 0.95);
    if (more_at > 100.0 * k && more_at < 100.0 * (k + 1)) r.add(more_at, quality);
  }
  return r;
}

std::vector<TooClose> too_close(const Row& r, std::span<const double> times_s = {}) {
  return find_too_close(r.path, r.points, r.quality, times_s);
}

}  // namespace

TEST_GROUP(Crowding){};

TEST(Crowding, FindsTheOneThatIsLessOfABall) {
  const auto found = too_close(row(330.0, 0.4));
  LONGS_EQUAL(1, found.size());
  LONGS_EQUAL(4, found[0].index);
  LONGS_EQUAL(3, found[0].neighbour);
  DOUBLES_EQUAL(30.0 * std::sqrt(2.0), found[0].distance_px, 1e-9);
}

TEST(Crowding, LeavesUnequalStepsOfAsGoodImages) { LONGS_EQUAL(0, too_close(row(330.0, 0.93)).size()); }

TEST(Crowding, LeavesAnImageThatAnotherHidesByHalf) { LONGS_EQUAL(0, too_close(row(330.0, 0.68)).size()); }

TEST(Crowding, IsCertainWhereNoTrainHasSuchAnInterval) {
  // The second outline of one ball shares most of its limb.
  LONGS_EQUAL(1, too_close(row(308.0, 0.93)).size());
}

TEST(Crowding, OnACurveIsNearnessAcrossThePictureAndOnIt) {
  const auto curve = [](Row r) {
    r.path.curved = true;
    return r;
  };
  LONGS_EQUAL(1, too_close(curve(row(308.0, 0.93))).size());
  LONGS_EQUAL(0, too_close(curve(row(330.0, 0.93))).size());
  // Thrown up, and up and down: at the top the images are near each other, and there are steps as long across.
  for (const double across_px : {100.0, 0.1}) {
    Row thrown;
    for (int k = -4; k <= 4; ++k) {
      thrown.add(across_px * k, 0.6);
      thrown.points.back().at.y = 80.0 * k * k;
    }
    LONGS_EQUAL(0, too_close(curve(thrown)).size());
  }
}

TEST(Crowding, IsCertainWhereTheFlashesAreEven) {
  const std::vector<double> even{0.0, 3e-3, 6e-3, 9e-3, 12e-3, 15e-3, 18e-3, 21e-3, 24e-3, 27e-3};
  LONGS_EQUAL(1, too_close(row(330.0, 0.93), even).size());
  // Two flashes as near as the two images.
  const std::vector<double> uneven{0.0, 3e-3, 6e-3, 9e-3, 9.9e-3, 12e-3, 15e-3, 18e-3, 21e-3, 24e-3};
  LONGS_EQUAL(0, too_close(row(330.0, 0.93), uneven).size());
}

TEST(Crowding, NeedsABetterImageTheShorterTheStepIs) {
  // A log-normal density over an even one: even odds at a step of .2 are those of .81.
  LONGS_EQUAL(1, too_close(row(320.0, 0.7)).size());
  LONGS_EQUAL(0, too_close(row(320.0, 0.9)).size());
}

TEST(Crowding, OfAShortLegIsNotTold) {
  Row r;
  for (const double x : {0.0, 100.0, 110.0}) r.add(x, x == 110.0 ? 0.4 : 0.95);
  LONGS_EQUAL(0, too_close(r).size());
}

// What is known of an outline adds up.
TEST_GROUP(BallOdds){};

TEST(BallOdds, AreThoseOfThePicturesOtherOutlines) {
  // Outlines that are certainly balls' or certainly none count for what they are, beside one of either.
  std::vector<double> odds(8, 20.0);
  odds.resize(10, -20.0);
  DOUBLES_EQUAL(std::log(9.0 / 3.0), log_prior(odds), 1e-6);
  odds.assign(8, -20.0);
  odds.push_back(20.0);
  DOUBLES_EQUAL(std::log(2.0 / 9.0), log_prior(odds), 1e-6);
  DOUBLES_EQUAL(0.0, log_prior({}), 0.0);
  DOUBLES_EQUAL(0.0, log_prior(std::vector{0.0, 0.0}), 1e-12);
}

TEST(BallOdds, FallSteadilyWithTheDifferenceInSize) {
  const SizeModel size{260.0, 0.0, 0.3};
  const std::vector<LimbAgreement> limbs(2);
  const auto odds = [&](double diameter) {
    return log_odds_of(std::vector{ball_at(0.0, 260.0), ball_at(0.0, diameter)}, limbs, size)[1];
  };
  CHECK_TRUE(odds(260.0 * 1.03) < odds(260.0));
  CHECK_TRUE(odds(260.0 * 1.05) < odds(260.0 * 1.03));
  // Far off it is one of another size: one ball in twenty, at most.
  CHECK_TRUE(odds(260.0 * 1.4) < odds(260.0 * 1.05));
  DOUBLES_EQUAL(odds(260.0 * 1.4), odds(260.0 * 2.0), 1e-3);
}

TEST(BallOdds, LeaveAnOutlineOfWhichOneSideIsMovedAsUncertainAsItIsOff) {
  constexpr int kRays = 72;
  const SizeModel size{260.0, 0.0, 0.1};
  double squares = 0.0, size_squares = 0.0, count = 0.0;
  for (int turn = 0; turn < kRays; ++turn) {
    for (const double moved : {-8.0, -5.0, 5.0, 8.0}) {
      // Least squares of a circle through rays of which half are longer.
      cv::Vec3d sum;
      for (int k = 0; k < kRays; ++k) {
        const double angle = 2.0 * CV_PI * k / kRays;
        const double beyond = (k - turn + kRays) % kRays < kRays / 2 ? moved : 0.0;
        sum += beyond * cv::Vec3d(2.0 * std::cos(angle), 2.0 * std::sin(angle), 2.0) * (1.0 / kRays);
      }
      Outline outline = ball_at(700.0 + sum[0], 260.0 + sum[2], 0.3);
      outline.moved_limb_px = moved_limb_px(outline, size);
      add_moved_limb(outline);
      squares += sum[0] * sum[0] / outline.covariance(0, 0) + sum[1] * sum[1] / outline.covariance(1, 1);
      size_squares += sum[2] * sum[2] / outline.covariance(2, 2);
      count += 1.0;
    }
  }
  // Beside the outline's own .3 px, and where they are off by their true sd in every case.
  DOUBLES_EQUAL(2.0, squares / count, 0.1);
  DOUBLES_EQUAL(1.0, size_squares / count, 0.05);
  // Chance has as many as one in three outlines a sd off, and tells nothing of any limb.
  Outline as_others = ball_at(700.0, 260.0 + 0.3, 0.3);
  as_others.moved_limb_px = moved_limb_px(as_others, size);
  add_moved_limb(as_others);
  DOUBLES_EQUAL(0.3, as_others.centre_sd(), 0.003);
}

TEST(BallOdds, RiseOnALegTheMoreTheBetterTheCentreIsKnown) {
  Photograph photograph;
  photograph.intensity = cv::Mat::zeros(1000, 1500, CV_32FC1);
  const auto on_leg = [&](double sd) {
    return log_odds_of_path(ball_at(700.0, 100.0, sd), photograph, PlaneMap::uncalibrated(1000));
  };
  CHECK_TRUE(on_leg(0.2) > on_leg(1.0));
  CHECK_TRUE(on_leg(1.0) > on_leg(4.0));
  CHECK_TRUE(on_leg(4.0) > 0.0);
}

// Outlines distinguished from arcs that only look like one, by the light across them.
namespace {

namespace painter = strobe::testing;

constexpr double kLimb_px = 80.0;
constexpr int kHeight = 300;

/// Images in a row that overlap, 3/4 of a diameter apart.
painter::Painting row_of_balls(std::uint64_t seed, int count, double light) {
  std::mt19937_64 random(seed);
  painter::Painting painting;
  painting.width = 560;
  painting.height = kHeight;
  painting.bits = 16;
  painting.seed = seed;
  painter::PaintedBall look = painter::random_ball(random, {}, kLimb_px);
  look.light = light;
  for (int k = 0; k < count; ++k) {
    look = painter::next_image(look, {80.0 + 60.0 * k, 200.0 - 12.0 * k}, 0.2);
    painting.balls.push_back(look);
  }
  return painting;
}

Outline outline_at(cv::Point2d image_px) {
  Outline outline;
  outline.centre = {image_px.x, kHeight - 1 - image_px.y};
  outline.diameter = kLimb_px;
  outline.blur_px = 1.0;
  return outline;
}

std::vector<LimbAgreement> looked_at(const painter::Painting& painting, const std::vector<Outline>& outlines,
                                     const std::optional<SurfaceLine>& surface = std::nullopt) {
  return compare_limbs(painter::paint(painting), PlaneMap::uncalibrated(kHeight), outlines, surface);
}

}  // namespace

TEST_GROUP(LimbAgreement){};

TEST(LimbAgreement, KnowsABallsLimbWhereFalseOutlinesOutnumberTheBalls) {
  const auto painting = row_of_balls(5, 4, 0.12);
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) {
    outlines.push_back(outline_at(ball.centre));
    outlines.back().visible_fraction = 0.8;
  }
  // On the even background above them.
  for (int k = 0; k < 10; ++k) {
    outlines.push_back(outline_at({100.0 + 36.0 * k, 60.0}));
    outlines.back().visible_fraction = 0.25;
  }
  const auto limbs = looked_at(painting, outlines);
  for (std::size_t i = 0; i < painting.balls.size(); ++i) CHECK_TRUE(limbs[i].log_odds > kCertainOdds);
  for (std::size_t i = painting.balls.size(); i < limbs.size(); ++i)
    CHECK_TRUE(limbs[i].log_odds < -kCertainOdds);
}

TEST(LimbAgreement, KnowsABallsLimbWhereGhostsOutnumberTheBalls) {
  // Ghosts of an eighth of the balls' light, in a row of their own.
  auto painting = row_of_balls(5, 3, 0.3);
  std::vector<Outline> outlines;
  for (std::size_t k = 0; k < 8; ++k) {
    auto ghost = painting.balls.front();
    ghost.light /= 8.0;
    ghost.centre = {60.0 + 55.0 * static_cast<double>(k), 60.0};
    painting.balls.push_back(ghost);
  }
  for (const auto& disc : painting.balls) {
    outlines.push_back(outline_at(disc.centre));
    outlines.back().visible_fraction = 0.6;
  }
  const auto limbs = looked_at(painting, outlines);
  for (std::size_t i = 0; i < limbs.size(); ++i)
    CHECK_TRUE(i < 3 ? limbs[i].log_odds > 0.0 : limbs[i].log_odds < 0.0);
}

TEST(LimbAgreement, IsABallsTheLikelierTheMoreOfItsOutlineIsSeen) {
  const auto painting = row_of_balls(5, 4, 0.12);
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  double before = -1e9;
  for (const double seen : {0.2, 0.5, 0.9}) {
    outlines.front().visible_fraction = seen;
    const double now = looked_at(painting, outlines).front().log_odds;
    CHECK_TRUE(now > before);
    before = now;
  }
}

TEST(LimbAgreement, OfASecondOutlineOfABallIsNothingAsItsLimbIsTheBetterOnes) {
  const auto painting = row_of_balls(5, 4, 0.12);
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) {
    outlines.push_back(outline_at(ball.centre));
    outlines.back().visible_fraction = 0.9;
    outlines.back().visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  }
  // Nearer all around than where light is sampled: 3.5 px at a blur of one.
  outlines.push_back(outline_at(painting.balls[1].centre + cv::Point2d(2.0, -2.0)));
  outlines.back().visible_fraction = 0.7;
  outlines.back().visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const auto limbs = looked_at(painting, outlines);
  DOUBLES_EQUAL(0.0, limbs.back().observed, 1e-9);
  CHECK_TRUE(limbs.back().log_odds < -kCertainOdds);
  for (std::size_t i = 0; i < painting.balls.size(); ++i) CHECK_TRUE(limbs[i].log_odds > kCertainOdds);
}

TEST(LimbAgreement, LosesTheDirectionsAloneInWhichTwoBallsLimbsCross) {
  // 61 px apart, circles of 80 px cross at an angle of 40 degrees to the line between them, where 3.5 px on either side
  // are 3.5 / (61 sin 40) rad: eight degrees of 360, twice, four directions of 72 on either, give or take one each.
  const auto painting = row_of_balls(5, 2, 0.12);
  const auto limbs =
      looked_at(painting, {outline_at(painting.balls[0].centre), outline_at(painting.balls[1].centre)});
  const double least = std::min(limbs[0].observed, limbs[1].observed);
  DOUBLES_EQUAL(1.0, std::max(limbs[0].observed, limbs[1].observed), 1e-9);
  DOUBLES_EQUAL(1.0 - 6.0 / 72.0, least, 2.1 / 72.0);
}

// A single ball in a lit room, beside furniture: arcs of the bright edges below it are more.
TEST(LimbAgreement, KnowsTheOnlyWholeBallAmongArcsOfBrighterThings) {
  auto painting = row_of_balls(5, 5, 0.3);
  painting.balls.front().centre = {80.0, 60.0};
  painting.balls.front().light = 0.1;
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) {
    outlines.push_back(outline_at(ball.centre));
    outlines.back().centre.y -= 8.0;  // on their upper edges only
    outlines.back().visible_fraction = 0.2;
  }
  outlines.front() = outline_at(painting.balls.front().centre);
  outlines.front().visible_fraction = 0.8;
  CHECK_TRUE(looked_at(painting, outlines).front().log_odds > kCertainOdds);
}

TEST(LimbAgreement, TellsBallsFromACircleHalfWayBetweenTwo) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto painting = row_of_balls(seed, 6, 0.12);
    std::vector<Outline> outlines;
    for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
    outlines.push_back(outline_at(0.5 * (painting.balls[2].centre + painting.balls[3].centre)));
    const auto limbs = looked_at(painting, outlines);
    for (std::size_t i = 0; i + 1 < outlines.size(); ++i) CHECK_TRUE(limbs[i].agreement > 0.6);
    CHECK_TRUE(limbs.back().agreement < 0.5);
  }
}

TEST(LimbAgreement, MindsNeitherALampThatFailsNorAFlashThatIsWeak) {
  auto painting = row_of_balls(5, 6, 0.2);
  for (auto& ball : painting.balls) ball.lamps.resize(1);
  painting.balls[3].light *= 0.5;
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  for (const LimbAgreement& limb : looked_at(painting, outlines)) CHECK_TRUE(limb.agreement > 0.6);
}

TEST(LimbAgreement, SaysHowLittleCanBeTold) {
  const auto painting = row_of_balls(3, 5, 2.5);  // overlaps and middles saturated
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  outlines.push_back(outline_at({5.0, 290.0}));  // a quarter is on the photograph
  const auto limbs = looked_at(painting, outlines);
  CHECK_TRUE(limbs[2].observed < 0.9);
  CHECK_TRUE(limbs.back().observed < 0.45);
}

TEST(LimbAgreement, LeavesOutWhatLiesBelowTheSurface) {
  const auto painting = row_of_balls(7, 4, 0.2);
  std::vector<Outline> outlines;
  for (const auto& ball : painting.balls) outlines.push_back(outline_at(ball.centre));
  SurfaceLine surface;  // through the first ball's middle
  surface.points = {{0.0, outlines[0].centre.y}, {560.0, outlines[0].centre.y}};
  const auto limbs = looked_at(painting, outlines, surface);
  // A half, but for the directions on the line itself.
  DOUBLES_EQUAL(0.5, limbs[0].observed, 0.06);
  CHECK_TRUE(limbs[3].observed > 0.75);  // 36 px higher: little of it lies below
}

TEST(LimbAgreement, OfNothingIsNothing) { LONGS_EQUAL(0, looked_at(row_of_balls(1, 0, 0.2), {}).size()); }
