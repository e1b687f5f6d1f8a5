// How high a ball rises and how fast one lands, in air.
#include "common/flight/vertical.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <CppUTest/TestHarness.h>

using namespace strobe::flight;

namespace {

constexpr double kG = kStandardGravity_mps2;
// Tennis ball, basketball, table-tennis ball, and some that hardly feel the air.
constexpr double kDrags_per_m[] = {0.0, 1e-12, 1e-7, 0.02, 0.022, 0.14};

/// The equation of motion by Runge and Kutta's fourth-order rule from the top down, in u = v^2 by the height, so that
/// nothing is singular: du/dh = 2 (g + k u) of a rise, 2 (g - k u) of a fall.
double square_of_speed(double height_m, double drag_per_m, double sign) {
  constexpr int kSteps = 400;
  const double h = height_m / kSteps;
  const auto slope = [&](double u) { return 2.0 * (kG + sign * drag_per_m * u); };
  double u = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double a = slope(u), b = slope(u + 0.5 * h * a), c = slope(u + 0.5 * h * b), d = slope(u + h * c);
    u += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
  }
  return u;
}

/// Central differences: of a smooth f with steps of 1e-5 right to 1e-10 by truncation, 1e-11 by rounding.
double slope(const std::function<double(double)>& f, double x) {
  const double h = 1e-5 * std::max(std::abs(x), 0.1);
  return (f(x + h) - f(x - h)) / (2.0 * h);
}

}  // namespace

TEST_GROUP(VerticalFlight){};

TEST(VerticalFlight, RisesAndFallsAsTheEquationOfMotionSays) {
  for (const double k : kDrags_per_m)
    for (const double h : {0.01, 0.23, 1.4, 2.54}) {
      // Fourth order with 400 steps of k h / 200 at most: below 1e-12.
      DOUBLES_EQUAL(std::sqrt(square_of_speed(h, k, 1.0)), rise_speed_mps(h, k).value, 1e-9);
      DOUBLES_EQUAL(std::sqrt(square_of_speed(h, k, -1.0)), fall_speed_mps(h, k).value, 1e-9);
    }
}

TEST(VerticalFlight, GoesBackToWhereItCameFrom) {
  for (const double k : kDrags_per_m)
    for (const double h : {1e-6, 0.3, 2.54}) {
      DOUBLES_EQUAL(h, rise_m(rise_speed_mps(h, k).value, k).value, 1e-12);
      DOUBLES_EQUAL(h, fall_m(fall_speed_mps(h, k).value, k).value, 1e-12);
    }
}

TEST(VerticalFlight, HasTheDerivativesOfItsValues) {
  for (const double k : {0.0, 1e-6, 0.02, 0.14})
    for (const auto& f : {rise_m, fall_m, rise_speed_mps, fall_speed_mps}) {
      const VerticalNumber at = f(2.0, k, kG);
      DOUBLES_EQUAL(slope([&](double x) { return f(x, k, kG).value; }, 2.0), at.by_input, 1e-7);
      const double more = f(2.0, k + 2e-5, kG).value, most = f(2.0, k + 4e-5, kG).value;
      // One-sided of second order, since no drag is below none.
      const double by_drag = (4.0 * more - most - 3.0 * at.value) / 4e-5;
      DOUBLES_EQUAL(by_drag, at.by_drag_per_m, 1e-5);
    }
}

TEST(VerticalFlight, OfABallAtRestGoesNowhere) {
  DOUBLES_EQUAL(0.0, rise_m(0.0, 0.02).value, 0.0);
  DOUBLES_EQUAL(0.0, fall_speed_mps(0.0, 0.02).value, 0.0);
}

TEST(VerticalFlight, EndsInNoFallBeyondTheTerminalSpeed) {
  CHECK_TRUE(std::isinf(fall_m(1.001 * std::sqrt(kG / 0.14), 0.14).value));
  CHECK_TRUE(std::isfinite(fall_m(0.999 * std::sqrt(kG / 0.14), 0.14).value));
}
