// The two flights of this project against each other: the rig's Runge-Kutta steps, which are its truth, and
// the reduction's third-order series. They share no code. What a flight without drag keeps, it keeps here
// too.
#include <cmath>
#include <limits>

#include "common/flight/aerodynamics.hpp"
#include "sim/motion/flight.hpp"
#include "tests/common/convergence/orders.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using strobe::testing::order_above;
using strobe::testing::Refinement;

namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();
const sim::FlightState kStart{.x_m = 0.3, .y_m = 0.2, .vx_mps = 15.0, .vy_mps = -6.0};
constexpr double kSpin_radps = 200.0;
const double kSpeed_mps = std::hypot(15.0, 6.0);

sim::Scene scene_of(double density_kgpm3, double drag_coefficient = 0.55) {
  sim::Scene scene;
  scene.air.density_kgpm3 = density_kgpm3;
  scene.air.drag_coefficient = drag_coefficient;
  scene.air.spin_decay_per_m = 0.0;  // the series' spin is constant
  return scene;
}

sim::FlightState flown(const sim::Scene& scene, const sim::FlightState& from, double spin, double time_s) {
  return sim::Flight(scene, from, spin).at(time_s);
}

/// In so many flights one after another.
sim::FlightState in_parts(const sim::Scene& scene, sim::FlightState s, double time_s, int parts) {
  for (int i = 0; i < parts; ++i) s = flown(scene, s, kSpin_radps, time_s / parts);
  return s;
}

flight::Flight series_of(const sim::Scene& scene) {
  const auto air = flight::aerodynamics(scene.ball, scene.air.density_kgpm3);
  const Eigen::Vector2d velocity{kStart.vx_mps, kStart.vy_mps};
  return {{kStart.x_m, kStart.y_m},
          velocity,
          flight::forcing(air, flight::gravity_mps2(0.0), velocity, kSpin_radps)};
}

double distance(const sim::FlightState& a, const sim::FlightState& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

TEST_GROUP(FlightConvergence){};

// One step of the classical method errs by the fifth power of its length. In air 400 times as dense as ours,
// since in ours the error is rounding (next test).
TEST(FlightConvergence, OneStepOfTheRigsFlightErrsByTheFifthPower) {
  const sim::Scene thick = scene_of(500.0);
  std::vector<Refinement> errors;
  for (const double per_step : {1.0, 2.0, 4.0, 8.0}) {
    const double h = 2e-3 / per_step;
    const sim::FlightState exact = in_parts(thick, kStart, h, 64);
    errors.push_back({per_step, distance(flown(thick, kStart, kSpin_radps, h), exact)});
  }
  DOUBLES_EQUAL(5.0, order_above(errors, 1e-15), 0.3);
}

// 80 steps of 2 ms, 1280 of an eighth: what differs is the roundings of the way flown, 2.6 m.
TEST(FlightConvergence, InOurAirTheRigsStepsErrByRounding) {
  const sim::Scene scene = scene_of(1.2);
  const sim::FlightState a = flown(scene, kStart, kSpin_radps, 0.16);
  const sim::FlightState b = in_parts(scene, kStart, 0.16, 1280);
  DOUBLES_EQUAL(0.0, distance(a, b), 1280.0 * kRounding * 2.6);
  DOUBLES_EQUAL(b.vx_mps, a.vx_mps, 1280.0 * kRounding * 16.0);
  DOUBLES_EQUAL(b.vy_mps, a.vy_mps, 1280.0 * kRounding * 16.0);
}

// The series holds acceleration and jerk: positions err by the fourth power of time, velocities by the third.
TEST(FlightConvergence, TheReductionsSeriesErrsByTheFourthPower) {
  const sim::Scene scene = scene_of(1.2);
  const flight::Flight series = series_of(scene);
  std::vector<Refinement> places, speeds;
  for (const double parts : {1.0, 2.0, 4.0, 8.0}) {
    const double t = 0.08 / parts;
    const sim::FlightState exact = flown(scene, kStart, kSpin_radps, t);
    const Eigen::Vector2d p = series.position_at(t), v = series.velocity_at(t);
    places.push_back({parts, std::hypot(p.x() - exact.x_m, p.y() - exact.y_m)});
    speeds.push_back({parts, std::hypot(v.x() - exact.vx_mps, v.y() - exact.vy_mps)});
  }
  DOUBLES_EQUAL(4.0, order_above(places, 1e-14), 0.2);
  DOUBLES_EQUAL(3.0, order_above(speeds, 1e-13), 0.2);
}

// Without drag and decay the laws are the same backwards: thrown back from the end, with the spin turned
// round, the ball returns to where it came from. (The lift's v·(z × v)·C_L(omega) keeps its sign.)
TEST(FlightConvergence, AFlightWithoutDragRunsBackToItsStart) {
  const sim::Scene scene = scene_of(1.2, 0.0);
  for (const double time_s : {0.003, 0.05, 0.4, -0.2}) {
    const sim::FlightState end = flown(scene, kStart, kSpin_radps, time_s);
    sim::FlightState back = end;
    back.vx_mps = -end.vx_mps;
    back.vy_mps = -end.vy_mps;
    const sim::FlightState start = flown(scene, back, -kSpin_radps, time_s);
    // 200 steps there and back.
    DOUBLES_EQUAL(0.0, distance(kStart, start), 400.0 * kRounding * (1.0 + kSpeed_mps * std::abs(time_s)));
    DOUBLES_EQUAL(-kStart.vx_mps, start.vx_mps, 400.0 * kRounding * kSpeed_mps);
    DOUBLES_EQUAL(-kStart.vy_mps, start.vy_mps, 400.0 * kRounding * kSpeed_mps);
  }
}

// With drag it does not: what it lost it does not get back.
TEST(FlightConvergence, AFlightWithDragDoesNot) {
  const sim::Scene scene = scene_of(1.2);
  sim::FlightState back = flown(scene, kStart, kSpin_radps, 0.4);
  back.vx_mps = -back.vx_mps;
  back.vy_mps = -back.vy_mps;
  CHECK(distance(kStart, flown(scene, back, -kSpin_radps, 0.4)) > 0.1);
}
