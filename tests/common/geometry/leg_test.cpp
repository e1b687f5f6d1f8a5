// A leg's flight through its images, and where it meets the surface.

#include "common/geometry/leg.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::geometry;
using Eigen::Vector2d;

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
