// Which round things are one ball's, in what order and when, from places alone.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/digitize/path/image_order.hpp"
#include "host/digitize/path/path.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::digitize;
using strobe::reduction::Leg;

constexpr double kDiameter_px = 260.0;
constexpr double kPeriod_s = 3e-3;
constexpr double kScale_px = 4000.0;

/// A ball that bounces at x = 0 above a level surface at y = 0, as every flash sees it.
struct Shot {
  double angle_deg = -23.0, speed_mps = 17.0, restitution = 0.75, friction = 0.2;
  double first_flash_s = 0.0007;  ///< after the ball is in view
  double reach_px = 1200.0, dwell_s = 4.5e-3;
  bool leftwards = false;

  struct Image {
    PathPoint point;
    Leg leg;
    double time_s;
  };

  std::vector<Image> images(double missing_time_s = -1.0) const {
    const double vx = speed_mps * std::cos(angle_deg * CV_PI / 180.0) * kScale_px;
    const double vy = speed_mps * std::sin(angle_deg * CV_PI / 180.0) * kScale_px;
    const double out_y = -restitution * vy, out_x = vx - friction * (out_y - vy);
    const double radius = 0.5 * kDiameter_px, contact_x = 0.5 * (vx + out_x) * dwell_s;
    std::vector<Image> all;
    for (int k = -20; k < 20; ++k) {
      const double t = k * kPeriod_s + first_flash_s;
      if (std::abs(t - missing_time_s) < 1e-9) continue;
      Image image{};
      image.time_s = t;
      cv::Point2d at;
      if (t < 0.0) {
        image.leg = Leg::incoming;
        at = {vx * t, radius + vy * t};
      } else if (t > dwell_s) {
        image.leg = Leg::rebound;
        at = {contact_x + out_x * (t - dwell_s), radius + out_y * (t - dwell_s)};
      } else {
        image.leg = Leg::contact;
        const double s = t / dwell_s;
        at = {contact_x * s, radius - 0.4 * radius * std::sin(CV_PI * s)};
      }
      if (std::abs(at.x) > reach_px || at.y > 0.9 * reach_px) continue;
      if (leftwards) at.x = -at.x;
      image.point = {at, 0.1, 0.95};
      all.push_back(image);
    }
    return all;
  }
};

std::vector<PathPoint> shuffled(const std::vector<Shot::Image>& images, std::vector<int>& order,
                                std::uint64_t seed) {
  std::mt19937_64 random(seed);
  order.resize(images.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::shuffle(order.begin(), order.end(), random);
  std::vector<PathPoint> points;
  for (const int i : order) points.push_back(images[static_cast<std::size_t>(i)].point);
  return points;
}

std::vector<double> flashes() {
  std::vector<double> times;
  for (int k = -20; k < 20; ++k) times.push_back(k * kPeriod_s);
  return times;
}

TimeContext scene(bool surface, std::span<const double> times = {}) {
  TimeContext s;
  s.path = {kDiameter_px, surface, 0.1};
  s.px_per_m = kScale_px;
  s.path.flash_times_s = times;
  return s;
}

/// Legs and order are the shot's own.
void check_order(const Shot& shot, const TimeContext& s, bool contacts = true) {
  std::vector<Shot::Image> images = shot.images();
  if (!contacts) std::erase_if(images, [](const Shot::Image& i) { return i.leg == Leg::contact; });
  std::vector<int> order;
  const auto points = shuffled(images, order, 7);
  const Path path = find_path(points, s.path);
  LONGS_EQUAL(0, path.outliers.size());
  const TimeOrder result = order_in_time(points, path, s);
  LONGS_EQUAL(images.size(), result.sequence.size());
  for (std::size_t k = 0; k < images.size(); ++k) {
    LONGS_EQUAL(k, order[static_cast<std::size_t>(result.sequence[k])]);
    CHECK_EQUAL(images[k].leg, result.leg[k]);
  }
}

}  // namespace

TEST_GROUP(BallPath){};

TEST(BallPath, IsOrderedAtEveryAngleInBothDirections) {
  for (const double angle : {-17.0, -23.0, -35.0, -48.0, -60.0, -71.0}) {
    for (const double first : {0.0003, 0.0012, 0.0021, 0.0027}) {
      for (const bool leftwards : {false, true}) {
        Shot shot;
        shot.angle_deg = angle;
        shot.first_flash_s = first;
        shot.leftwards = leftwards;
        check_order(shot, scene(true));
      }
    }
  }
}

TEST(BallPath, IsFoundWithoutASurface) {
  for (const double angle : {-20.0, -40.0, -60.0}) {
    Shot shot;
    shot.angle_deg = angle;
    check_order(shot, scene(false), false);
  }
}

TEST(BallPath, LeavesOutWhatIsNotOnIt) {
  const Shot shot;
  auto images = shot.images();
  const std::size_t own = images.size();
  for (const cv::Point2d at : {cv::Point2d(-200, 700), cv::Point2d(900, 150), cv::Point2d(100, -300)})
    images.push_back({{at, 0.1, 0.9}, Leg::incoming, 0.0});
  std::vector<int> order;
  const auto points = shuffled(images, order, 3);
  const Path path = find_path(points, scene(true).path);
  LONGS_EQUAL(3, path.outliers.size());
  for (const auto& outlier : path.outliers)
    CHECK_TRUE(order[static_cast<std::size_t>(outlier.index)] >= static_cast<int>(own));
}

// Beyond four sd of its own distance, to which the leg's uncertainty belongs, lies one image in 16,000. The legs
// are fitted with the images they judge, which are nearer then: none of 2,000 is expected beyond.
TEST(BallPath, KeepsImagesOfPoorPrecisionThatItsOwnUncertaintyExplains) {
  std::mt19937_64 random(20);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> log_sd(std::log(0.3), std::log(3.0));
  const PathContext context{60.0, false, 0.0};
  int off = 0;
  for (int shot = 0; shot < 400; ++shot) {
    std::vector<PathPoint> points;
    for (const double x : {-200.0, -170.0, -75.0, 30.0, 210.0}) {
      const double sd = std::exp(log_sd(random));
      points.push_back(
          {{x, 300.0 + 0.5 * x - 1e-4 * x * x + sd * normal(random)}, sd / std::hypot(1.0, 0.5), 1.0});
    }
    off += static_cast<int>(find_path(points, context).outliers.size());
  }
  LONGS_EQUAL(0, off);
}

TEST(BallPath, HasNoSecondLegOfPlacesAtRandom) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> x(0.0, 1500.0), y(0.0, 1000.0);
  constexpr int kSets = 400;
  int invented = 0;
  for (int set = 0; set < kSets; ++set) {
    std::vector<PathPoint> points;
    for (const double along : {900.0, 1050.0, 1150.0, 1300.0})
      points.push_back({{along, 0.3 * along}, 0.3, 1.0});
    for (int k = 0; k < 4 + set % 6; ++k) points.push_back({{x(random), y(random)}, 0.7, 0.8});
    invented += find_path(points, {90.0, false, 0.0}).legs.size() > 1 ? 1 : 0;
  }
  // One in ten is allowed; the binomial's sd is 6.
  CHECK_COMPARE(invented, <, kSets / 10 + 4 * 6);
}

TEST(BallPath, HasASecondLegOfThreePlacesButNotOfTwoOutlinesOfOneThingAndAnother) {
  const auto legs_with = [](double apart_of_diameter) {
    std::vector<PathPoint> points;
    for (int k = 0; k < 4; ++k) points.push_back({{300.0 * (k + 1), 150.0 * (k + 1)}, 0.1, 0.95});
    // From its end upwards to the left, within a pixel of a line.
    const cv::Point2d up(-0.6, 0.8);
    points.push_back({400.0 * up, 1.0, 0.95});
    points.push_back({1500.0 * up, 1.0, 0.95});
    points.push_back({(1500.0 + apart_of_diameter * kDiameter_px) * up + cv::Point2d(0.8, 0.6), 1.0, 0.95});
    // Of six places that one leg leaves any two may make a line.
    for (const cv::Point2d junk : {cv::Point2d(1900.0, 300.0), {200.0, 1500.0}, {1400.0, -200.0}})
      points.push_back({junk, 1.0, 0.3});
    return find_path(points, scene(false).path).legs.size();
  };
  LONGS_EQUAL(2, legs_with(1.0));
  LONGS_EQUAL(1, legs_with(0.15));
}

TEST(BallPath, HasNoSecondLegOfTwoOutlinesOfOneThingAlone) {
  std::vector<PathPoint> points;
  for (int k = 0; k < 4; ++k) points.push_back({{300.0 * (k + 1), 150.0 * (k + 1)}, 0.1, 0.95});
  const cv::Point2d up(-0.6, 0.8);
  for (const double along : {0.5, 0.65}) points.push_back({along * kDiameter_px * up, 1.0, 0.95});
  LONGS_EQUAL(1, find_path(points, scene(false).path).legs.size());
}

TEST(BallPath, TakesTheTimesOfItsFlashesWithOneMissing) {
  const auto times = flashes();
  Shot shot;
  const double gone = -3.0 * kPeriod_s + shot.first_flash_s;
  auto images = shot.images(gone);
  std::vector<double> moved = times;
  for (double& t : moved) t += shot.first_flash_s;
  std::erase_if(moved, [gone](double t) { return std::abs(t - gone) < 1e-9; });
  std::vector<int> order;
  const auto points = shuffled(images, order, 5);
  const TimeContext s = scene(true, moved);
  const TimeOrder result = order_in_time(points, find_path(points, s.path), s);
  LONGS_EQUAL(images.size(), result.flash.size());
  for (std::size_t k = 0; k < images.size(); ++k) {
    // The place of the gap fixes which flash made which image.
    DOUBLES_EQUAL(images[k].time_s, moved[static_cast<std::size_t>(result.flash[k])], 1e-9);
  }
}

TEST(BallPath, OfOneLegGoesTheWayTheFlashesSay) {
  // Unequal intervals: only one direction gives a steady speed.
  const std::vector<double> times{0.0, 0.004, 0.006, 0.011, 0.012, 0.02};
  for (const bool leftwards : {false, true}) {
    std::vector<PathPoint> points;
    for (const double t : times) {
      const double x = 60000.0 * t * (leftwards ? -1.0 : 1.0);
      points.push_back({{x, 300.0 - 10000.0 * t}, 0.1, 1.0});
    }
    const TimeContext s = scene(false, times);
    const TimeOrder result = order_in_time(points, find_path(points, s.path), s);
    CHECK_EQUAL(leftwards, result.leftwards);
    for (std::size_t k = 0; k < times.size(); ++k) LONGS_EQUAL(k, result.sequence[k]);
  }
}

TEST(BallPath, OfTwoFlightsOverEachOtherGetsNoTimes) {
  // Straight down and up again: every second image of the way down is hidden, and those of the way up lie
  // between.
  std::vector<PathPoint> points;
  for (int k = 0; k < 9; ++k) points.push_back({{0.0, 300.0 + 160.0 * k}, 0.2, 1.0});
  for (int k = 0; k < 9; ++k) points.push_back({{1.0, 345.0 + 117.0 * k}, 0.2, 1.0});
  const auto times = flashes();
  const Path untold = find_path(points, scene(true).path);
  const TimeOrder result = order_in_time(points, untold, scene(true, times));
  CHECK_TRUE(result.flash.empty());
  STRCMP_CONTAINS("flies along one line", result.remarks.back().c_str());
}

TEST(BallPath, HasNoPressedBallInALegWhereTheSurfaceIsHardlyKnown) {
  constexpr double kSurfaceSd_px = 10.0;
  int contacts = 0;
  for (const double off_px : {-20.0, -10.0, 0.0, 10.0, 20.0}) {  // of two sd
    for (int k = 0; k < 10; ++k) {
      Shot shot;
      shot.first_flash_s = 0.1 * k * kPeriod_s;
      shot.leftwards = k % 2 == 1;
      const std::vector<Shot::Image> images = shot.images();
      std::vector<int> order;
      std::vector<PathPoint> points = shuffled(images, order, 7);
      for (PathPoint& point : points) point.at.y += off_px;
      TimeContext s = scene(true, flashes());
      s.path.surface_sd_px = kSurfaceSd_px;
      const Path path = find_path(points, s.path);
      LONGS_EQUAL(0, path.outliers.size());
      LONGS_EQUAL(2, path.legs.size());
      const auto& in = path.legs[shot.leftwards ? 1 : 0];
      const auto& out = path.legs[shot.leftwards ? 0 : 1];
      for (const auto* leg : {&in, &out}) {
        for (const int i : *leg) {
          const Shot::Image& image = images[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])];
          // What is pressed by a twentieth of its radius is no longer where free flight would have it.
          CHECK(image.leg != Leg::contact || image.point.at.y > 0.95 * 0.5 * kDiameter_px);
        }
      }
      // No more than one flash falls within the five sd above the surface that the line and its error span.
      const auto airborne = std::ranges::count_if(
          images, [](const Shot::Image& image) { return image.leg != Leg::contact; });
      CHECK(static_cast<std::ptrdiff_t>(in.size() + out.size()) >= airborne - 2);
      contacts += static_cast<int>(path.contact.size());
    }
  }
  CHECK(contacts >= 50);
}

TEST(BallPath, OfNothingIsEmpty) {
  const Path path = find_path({}, scene(true).path);
  CHECK_TRUE(path.legs.empty() && path.contact.empty() && path.outliers.empty());
}
