#include "host/digitize/outliers/spacing.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;

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
  const auto found = too_close(row(330.0, 0.6));
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
  Row curved = row(308.0, 0.93);
  curved.path.curved = true;
  LONGS_EQUAL(0, too_close(curved).size());
}

TEST(Crowding, IsCertainWhereTheFlashesAreEven) {
  const std::vector<double> even{0.0, 3e-3, 6e-3, 9e-3, 12e-3, 15e-3, 18e-3, 21e-3, 24e-3, 27e-3};
  LONGS_EQUAL(1, too_close(row(330.0, 0.93), even).size());
  // Two flashes as near as the two images.
  const std::vector<double> uneven{0.0, 3e-3, 6e-3, 9e-3, 9.9e-3, 12e-3, 15e-3, 18e-3, 21e-3, 24e-3};
  LONGS_EQUAL(0, too_close(row(330.0, 0.93), uneven).size());
}

TEST(Crowding, OfAShortLegIsNotTold) {
  Row r;
  for (const double x : {0.0, 100.0, 110.0}) r.add(x, x == 110.0 ? 0.6 : 0.95);
  LONGS_EQUAL(0, too_close(r).size());
}
