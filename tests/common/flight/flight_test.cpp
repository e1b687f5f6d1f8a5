#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <numbers>

#include "common/flight/aerodynamics.hpp"
#include "common/flight/parabola.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::flight;
using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

const Vector2d kGravity(0.0, -9.80665);

struct State {
  Vector2d position, velocity;
};

/// The equations of motion written out by coefficients and unit vectors, integrated to 1e-13.
State integrated(const Vector2d& velocity, double omega, double time_s, bool drag = true, bool lift = true) {
  namespace odeint = boost::numeric::odeint;
  using Point = std::array<double, 4>;
  constexpr double kRadius = 0.0651 / 2;
  constexpr double kArea = std::numbers::pi * kRadius * kRadius;
  const auto system = [&](const Point& p, Point& d, double) {
    const double v = std::sqrt(p[2] * p[2] + p[3] * p[3]);
    const double pressure = 0.5 * 1.204 * v * v * kArea / 0.0576;
    const double cl = omega == 0.0 ? 0.0 : 1.0 / (2.0 + v / (kRadius * std::abs(omega)));
    const double push = drag ? pressure * 0.55 : 0.0;
    const double side = lift ? std::copysign(pressure * cl, omega) : 0.0;
    d = {p[2], p[3], (-push * p[2] - side * p[3]) / v, -9.80665 + (-push * p[3] + side * p[2]) / v};
  };
  Point p{0.0, 0.0, velocity.x(), velocity.y()};
  odeint::integrate_adaptive(odeint::make_controlled<odeint::runge_kutta_fehlberg78<Point>>(1e-13, 1e-13),
                             system, p, 0.0, time_s, time_s / 20);
  return {{p[0], p[1]}, {p[2], p[3]}};
}

Flight thrown(const Vector2d& velocity, double omega, Effects effects = {}) {
  return {Vector2d::Zero(), velocity,
          forcing(aerodynamics({}, kAirDensity_kgpm3, effects), kGravity, velocity, omega)};
}

double distance(const Vector2d& a, const Vector2d& b) { return (a - b).norm(); }

}  // namespace

TEST_GROUP(Aerodynamics){};

TEST(Aerodynamics, DragOfATennisBallIsOfTheSizeThatIsKnown) {
  // 1.204 / 2 x 0.55 x pi 0.03255^2 x 17^2 / 0.0576 = 5.53 m/s^2: 17 mm/s in 3 ms.
  const Aerodynamics air = aerodynamics({}, kAirDensity_kgpm3);
  DOUBLES_EQUAL(5.53, air.drag_mps2(17.0), 0.01);
}

TEST(Aerodynamics, LiftFollowsTheSpinRatio) {
  // At 300 rad/s the rim moves at 9.765 m/s; C_L = 1 / (2 + 17 / 9.765) = 0.2673.
  DOUBLES_EQUAL(0.2673, lift_coefficient(0.03255, 300.0, 17.0), 1e-4);
  DOUBLES_EQUAL(0.2673, lift_coefficient(0.03255, -300.0, 17.0), 1e-4);
  DOUBLES_EQUAL(0.0, lift_coefficient(0.03255, 0.0, 17.0), 0.0);
  DOUBLES_EQUAL(0.0, lift_coefficient(0.03255, 0.0, 0.0), 0.0);
  DOUBLES_EQUAL(0.5, lift_coefficient(0.03255, 1e12, 17.0), 1e-9);
}

TEST(Aerodynamics, BackspinLiftsAndTopspinPushesDown) {
  const Aerodynamics air = aerodynamics({}, kAirDensity_kgpm3, {.gravity = true, .drag = false});
  CHECK_TRUE(forcing(air, Vector2d::Zero(), {17.0, 0.0}, 300.0).acceleration_mps2.y() > 2.0);
  CHECK_TRUE(forcing(air, Vector2d::Zero(), {17.0, 0.0}, -300.0).acceleration_mps2.y() < -2.0);
  // Across the motion: no work.
  const Vector2d v{12.0, -7.0};
  const Vector2d a = forcing(air, Vector2d::Zero(), v, 250.0).acceleration_mps2;
  DOUBLES_EQUAL(0.0, a.dot(v), 1e-13);
}

TEST(Aerodynamics, TheMirrorImageOfAFlightIsAFlight) {
  const Aerodynamics air = aerodynamics({}, kAirDensity_kgpm3);
  const Forcing right = forcing(air, kGravity, {12.0, -7.0}, 250.0);
  const Forcing left = forcing(air, kGravity, {-12.0, -7.0}, -250.0);
  DOUBLES_EQUAL(right.acceleration_mps2.x(), -left.acceleration_mps2.x(), 0.0);
  DOUBLES_EQUAL(right.acceleration_mps2.y(), left.acceleration_mps2.y(), 0.0);
  DOUBLES_EQUAL(right.jerk_mps3.x(), -left.jerk_mps3.x(), 0.0);
  DOUBLES_EQUAL(right.jerk_mps3.y(), left.jerk_mps3.y(), 0.0);
}

TEST(Aerodynamics, WithoutMotionThereIsOnlyGravity) {
  const Forcing still = forcing(aerodynamics({}, kAirDensity_kgpm3), kGravity, Vector2d::Zero(), 300.0);
  DOUBLES_EQUAL(-9.80665, still.acceleration_mps2.y(), 0.0);
  DOUBLES_EQUAL(0.0, still.jerk_mps3.y(), 0.0);
}

TEST(Aerodynamics, DensityFollowsTheIdealGas) {
  DOUBLES_EQUAL(1.204, air_density_kgpm3(20.0), 0.0);
  DOUBLES_EQUAL(1.293, air_density_kgpm3(0.0), 1e-3);  // dry air at 0 degrees, printed in tables
}

TEST(Aerodynamics, TheDerivativeByVelocityIsThatOfTheAcceleration) {
  const Aerodynamics air = aerodynamics({}, kAirDensity_kgpm3);
  for (const Vector2d& v : {Vector2d{15.6, -6.7}, Vector2d{3.0, -25.0}, Vector2d{40.0, 1.0}}) {
    for (const double omega : {-400.0, -3.0, 0.0, 250.0}) {
      const Matrix2d m = forcing(air, kGravity, v, omega).by_velocity_per_s;
      // Central differences: h^2 of a third derivative below 1e-2, and rounding 1e-15 / 1e-3.
      const double h = 1e-3;
      const auto a = [&](double x, double y) {
        return forcing(air, kGravity, {v.x() + x, v.y() + y}, omega).acceleration_mps2;
      };
      DOUBLES_EQUAL((a(h, 0).x() - a(-h, 0).x()) / (2 * h), m(0, 0), 1e-7);
      DOUBLES_EQUAL((a(h, 0).y() - a(-h, 0).y()) / (2 * h), m(1, 0), 1e-7);
      DOUBLES_EQUAL((a(0, h).x() - a(0, -h).x()) / (2 * h), m(0, 1), 1e-7);
      DOUBLES_EQUAL((a(0, h).y() - a(0, -h).y()) / (2 * h), m(1, 1), 1e-7);
    }
  }
}

TEST_GROUP(FlightInAir){};

TEST(Aerodynamics, AnotherBallFliesByItsOwnLaw) {
  // A baseball's lift (Nathan 2008), written out; derivatives by central differences of 1e-4 m/s, whose error is of the
  // order of 1e-8 of the acceleration over a square metre per second.
  const AirLaw law{.drag_coefficient = 0.35, .lift_offset = 0.4, .lift_slope = 2.32};
  const ball::Ball baseball{.diameter_m = 0.0738, .mass_kg = 0.145, .alpha = 0.4};
  const Aerodynamics air = aerodynamics(baseball, 1.2, {}, law);
  constexpr double kSpeed_mps = 30.0, kOmega_radps = 200.0, kRatio = 0.0369 * kOmega_radps / kSpeed_mps;
  const double per_m = 1.2 * std::numbers::pi * 0.0369 * 0.0369 / (2.0 * 0.145);
  DOUBLES_EQUAL(per_m * 0.35 * 900.0, air.drag_mps2(kSpeed_mps), 1e-12);
  DOUBLES_EQUAL(per_m * 900.0 * kRatio / (0.4 + 2.32 * kRatio), air.lift_mps2(kSpeed_mps, kOmega_radps), 1e-12);
  const Vector2d v(24.0, 18.0);
  const Forcing at = forcing(air, kGravity, v, kOmega_radps);
  DOUBLES_EQUAL(air.lift_mps2(kSpeed_mps, kOmega_radps),
                (at.acceleration_mps2 - kGravity).dot(Vector2d(-v.y(), v.x())) / kSpeed_mps, 1e-12);
  for (int k = 0; k < 2; ++k) {
    const Vector2d step = 1e-4 * Vector2d::Unit(k);
    const Vector2d slope = (forcing(air, kGravity, v + step, kOmega_radps).acceleration_mps2 -
                            forcing(air, kGravity, v - step, kOmega_radps).acceleration_mps2) /
                           2e-4;
    CHECK_TRUE((slope - at.by_velocity_per_s.col(k)).norm() < 1e-7);
  }
  AirLaw without = law;
  without.lift_offset = 0.0;
  CHECK_EQUAL(0.0, aerodynamics(baseball, 1.2, {}, without).lift_mps2(kSpeed_mps, kOmega_radps));
}

TEST(FlightInAir, FollowsTheIntegratedPathToTheFourthOrder) {
  // What the series leaves out is snap t^3 / 6 and t^4 / 24. Drag alone, a = k v^2: the snap is 6 k^3 v^4,
  // 183 m/s^4 at 45 m/s (k = 0.0191 per m), with lift and gravity somewhat more: three times that bounds it.
  for (const double speed : {5.0, 17.0, 45.0}) {
    for (const double omega : {-500.0, 0.0, 500.0}) {
      const Vector2d v{speed * std::cos(0.4), -speed * std::sin(0.4)};
      const Flight series = thrown(v, omega);
      const double snap = 3 * (6 * std::pow(0.0191, 3) * std::pow(speed, 4) + 10.0);
      for (const double t : {-12e-3, -3e-3, 3e-3, 12e-3}) {
        const State exact = integrated(v, omega, t);
        const double size = std::abs(t);
        CHECK_TRUE(distance(exact.velocity, series.velocity_at(t)) < snap * std::pow(size, 3) / 6 + 1e-11);
        CHECK_TRUE(distance(exact.position, series.position_at(t)) < snap * std::pow(size, 4) / 24 + 1e-13);
      }
    }
  }
}

TEST(FlightInAir, TheJerkIsNeededAndEnoughForAThousandthOfAnSd) {
  // A good digitizer's speed is known to 0.05 m/s. Over 12 ms at 45 m/s the acceleration alone is wrong by
  // more than a hundredth of that, the series with the jerk by less than a thousandth.
  const Vector2d v{41.4, -17.5};
  Flight series = thrown(v, -300.0);
  const State exact = integrated(v, -300.0, 12e-3);
  CHECK_TRUE(distance(exact.velocity, series.velocity_at(12e-3)) < 1e-3 * 0.05);
  series.forcing.jerk_mps3.setZero();
  CHECK_TRUE(distance(exact.velocity, series.velocity_at(12e-3)) > 1e-2 * 0.05);
}

TEST(FlightInAir, CrossesAHeightWhereItsPathDoes) {
  for (const double height : {-0.05, -0.01, 0.02}) {
    const Flight falling = thrown({15.6, -6.7}, 100.0);
    const auto t = falling.time_falling_through_s(height);
    CHECK_TRUE(t.has_value());
    DOUBLES_EQUAL(height, falling.position_at(*t).y(), 1e-15);
    CHECK_TRUE(falling.velocity_at(*t).y() < 0.0);
    const Flight rising = thrown({8.8, 5.8}, -300.0);
    const auto up = rising.time_rising_through_s(height);
    CHECK_TRUE(up.has_value());
    DOUBLES_EQUAL(height, rising.position_at(*up).y(), 1e-15);
  }
  CHECK_FALSE(thrown({8.8, 1.0}, 0.0).time_rising_through_s(1.0).has_value());
}

using strobe::flight::gravity_mps2;
using strobe::flight::kStandardGravity_mps2;
using strobe::flight::Parabola;

TEST_GROUP(Flight){};

TEST(Flight, GravityPointsStraightDownOnALevelPlate) {
  DOUBLES_EQUAL(0.0, gravity_mps2(0.0).x(), 0.0);
  DOUBLES_EQUAL(-9.80665, gravity_mps2(0.0).y(), 0.0);
}

TEST(Flight, APlateThatRisesInTheDirectionOfTravelIsBrakedByGravity) {
  const auto g = gravity_mps2(std::asin(0.6));
  DOUBLES_EQUAL(-0.6 * kStandardGravity_mps2, g.x(), 1e-14);
  DOUBLES_EQUAL(-0.8 * kStandardGravity_mps2, g.y(), 1e-14);
}

TEST(Flight, ABallThrownUpPassesAHeightTwice) {
  // y = 1 + 3t - t²·5 with a = -10: passes 1.4 at t = 0.2 and 0.4.
  const Parabola path{{0.0, 1.0}, {2.0, 3.0}, {0.0, -10.0}};
  DOUBLES_EQUAL(0.2, *path.time_rising_through_s(1.4), 1e-15);
  DOUBLES_EQUAL(0.4, *path.time_falling_through_s(1.4), 1e-15);
  DOUBLES_EQUAL(0.4, path.position_at(0.2).x(), 1e-15);
  DOUBLES_EQUAL(1.0, path.velocity_at(0.2).y(), 1e-15);
}

TEST(Flight, AHeightAboveTheTopIsNeverReached) {
  const Parabola path{{0.0, 1.0}, {2.0, 3.0}, {0.0, -10.0}};
  CHECK_FALSE(path.time_rising_through_s(1.46).has_value());
  CHECK_FALSE(path.time_falling_through_s(1.46).has_value());
}

TEST(Flight, WithoutGravityAFallingBallNeverRises) {
  const Parabola path{{0.0, 0.5}, {16.0, -4.0}, {0.0, 0.0}};
  DOUBLES_EQUAL(0.1, *path.time_falling_through_s(0.1), 1e-16);
  CHECK_FALSE(path.time_rising_through_s(0.1).has_value());
}

TEST(Flight, TheTimeOfASmallDropKeepsItsDigitsUnderWeakGravity) {
  // drop 1e-9 m at 5 m/s: t = 2e-10 (1 + 2e-10·a/(2v)...); the textbook formula would lose 10 digits here.
  const Parabola path{{0.0, 1e-9}, {0.0, -5.0}, {0.0, -9.80665}};
  const double expected = 2e-10 * (1.0 - 9.80665 * 2e-10 / 10.0);
  DOUBLES_EQUAL(1.0, *path.time_falling_through_s(0.0) / expected, 1e-15);
}
