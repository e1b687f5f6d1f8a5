// The rig's flight against closed forms of each effect alone, and against the balance of power of all.
#include "sim/motion/flight.hpp"

#include <cmath>
#include <numbers>

#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;

constexpr double kGravity_mps2 = 9.80665;
const FlightState kStart{0.3, 0.2, 15.0, -6.0};
const double kSpeed_mps = std::hypot(15.0, 6.0);

/// Without gravity along the surface's normal there is none at all: the plate stands upright and x is known
/// to fall.
struct Air {
  double drag = 0.0;
  bool lift = false;
  double density = 1.2;
};

Scene scene_of(Air air) {
  Scene scene = test::plain_scene();
  scene.air.density_kgpm3 = air.density;
  scene.air.drag_coefficient = air.drag;
  scene.air.lift = air.lift;
  return scene;
}

/// density·pi·R²/(2·m) of the default ball.
double per_metre(double density) { return density * std::numbers::pi * 0.0651 * 0.0651 / (8.0 * 0.0576); }

/// What is left when the fall of a straight flight is taken off; exact only where gravity moves the ball by
/// too little to change drag and lift.
FlightState minus_fall(const FlightState& s, double t) {
  return {s.x_m, s.y_m + 0.5 * kGravity_mps2 * t * t, s.vx_mps, s.vy_mps + kGravity_mps2 * t};
}

}  // namespace

TEST_GROUP(RigFlight){};

TEST(RigFlight, IsAParabolaWithoutAir) {
  Scene scene = scene_of({.drag = 0.55, .lift = true, .density = 0.0});
  scene.surface_angle_rad = 0.3;
  const Flight flight(scene, kStart, 200.0);
  const double gx = -kGravity_mps2 * std::sin(0.3), gy = -kGravity_mps2 * std::cos(0.3);
  for (const double t : {-0.4, -0.01, 0.0, 0.003, 0.7}) {
    const FlightState s = flight.at(t);
    DOUBLES_EQUAL(kStart.x_m + t * (kStart.vx_mps + 0.5 * gx * t), s.x_m, 1e-12);
    DOUBLES_EQUAL(kStart.y_m + t * (kStart.vy_mps + 0.5 * gy * t), s.y_m, 1e-12);
    DOUBLES_EQUAL(kStart.vx_mps + gx * t, s.vx_mps, 1e-12);
    DOUBLES_EQUAL(kStart.vy_mps + gy * t, s.vy_mps, 1e-12);
  }
}

TEST(RigFlight, SlowsDownAsASquareLawDoes) {
  // Straight down without spin, v' = g - k·v²: v = w·tanh(g·t/w + artanh(v0/w)), w² = g/k.
  const double k = 0.6 * per_metre(1.2);
  const Flight flight(scene_of({.drag = 0.6}), {0.0, 0.0, 0.0, -12.0}, 0.0);
  const double w = std::sqrt(kGravity_mps2 / k), phase = std::atanh(12.0 / w);
  for (const double t : {-0.2, -0.004, 0.015, 0.5, 3.0}) {
    const double argument = kGravity_mps2 * t / w + phase;
    DOUBLES_EQUAL(-w * std::tanh(argument), flight.at(t).vy_mps, 1e-10);
    DOUBLES_EQUAL(-std::log(std::cosh(argument) / std::cosh(phase)) / k, flight.at(t).y_m, 1e-10);
    DOUBLES_EQUAL(0.0, flight.at(t).x_m, 1e-15);
  }
}

TEST(RigFlight, LiftTurnsThePathAndDoesNoWork) {
  // The speed follows the height alone, and the path's angle turns at q·C_L·v beside what gravity turns.
  const Flight flight(scene_of({.lift = true}), kStart, 300.0);
  const double start = 0.5 * kSpeed_mps * kSpeed_mps + kGravity_mps2 * kStart.y_m;
  for (const double t : {-0.3, -0.01, 0.02, 0.4}) {
    const FlightState s = flight.at(t);
    DOUBLES_EQUAL(start, 0.5 * (s.vx_mps * s.vx_mps + s.vy_mps * s.vy_mps) + kGravity_mps2 * s.y_m, 1e-9);
  }
  constexpr double h = 1e-4;  // the angle's third derivative is of order 1 rad/s³: h²/6 of it is 2e-9
  const FlightState a = flight.at(-h);
  const FlightState b = flight.at(h);
  const double rim = 0.0651 / 2 * 300.0, lift = rim / (2.0 * rim + kSpeed_mps);
  const double turn = (std::atan2(b.vy_mps, b.vx_mps) - std::atan2(a.vy_mps, a.vx_mps)) / (2 * h);
  DOUBLES_EQUAL(
      per_metre(1.2) * lift * kSpeed_mps - kGravity_mps2 * kStart.vx_mps / (kSpeed_mps * kSpeed_mps), turn,
      1e-7);
}

TEST(RigFlight, BackspinLiftsAndTopspinDrops) {
  const double plain = minus_fall(Flight(scene_of({.lift = true}), kStart, 0.0).at(0.02), 0.02).vy_mps;
  const double back = minus_fall(Flight(scene_of({.lift = true}), kStart, 300.0).at(0.02), 0.02).vy_mps;
  const double top = minus_fall(Flight(scene_of({.lift = true}), kStart, -300.0).at(0.02), 0.02).vy_mps;
  DOUBLES_EQUAL(kStart.vy_mps, plain, 1e-12);
  CHECK(back > plain + 0.03);
  CHECK(top < plain - 0.03);
  DOUBLES_EQUAL(back - plain, plain - top, 1e-3);
  // A ball that lifts twice as much; the path that it turns changes the speed along y by a thousandth.
  Scene twice = scene_of({.lift = true});
  twice.air.lift_factor = 2.0;
  const double more = minus_fall(Flight(twice, kStart, 300.0).at(0.02), 0.02).vy_mps;
  DOUBLES_EQUAL(2.0, (more - plain) / (back - plain), 0.02);
}

TEST(RigFlight, LosesThePowerThatDragTakes) {
  // d(v²/2 + g·y)/dt = -q·C_D·v³, by Simpson's rule over steps of 5 ms: its error is below 1e-12 of the loss.
  const double k = 0.55 * per_metre(1.2);
  const Flight flight(scene_of({.drag = 0.55, .lift = true}), kStart, -250.0);
  const auto energy = [](const FlightState& s) {
    return 0.5 * (s.vx_mps * s.vx_mps + s.vy_mps * s.vy_mps) + kGravity_mps2 * s.y_m;
  };
  const auto power = [&](double t) {
    const FlightState s = flight.at(t);
    return k * std::pow(std::hypot(s.vx_mps, s.vy_mps), 3);
  };
  constexpr double h = 5e-3;
  double taken = 0.0;
  for (int i = -20; i < 20; ++i)
    taken += h / 6.0 * (power(i * h) + 4.0 * power((i + 0.5) * h) + power((i + 1) * h));
  CHECK(taken > 1.0);
  DOUBLES_EQUAL(taken, energy(flight.at(-20 * h)) - energy(flight.at(20 * h)), 1e-8);
}

TEST(RigFlight, TakesItsDensityFromTheTemperature) {
  // Dry air at 101.325 kPa: 1.2250 kg/m³ at 15 degrees Celsius (ICAO standard atmosphere).
  Scene given = scene_of({.drag = 0.55, .lift = true, .density = 1.2250});
  Scene warm = given;
  warm.air.density_kgpm3 = -1.0;
  warm.air.temperature_c = 15.0;
  const double expected = Flight(given, kStart, 100.0).at(0.1).vx_mps;
  DOUBLES_EQUAL(expected, Flight(warm, kStart, 100.0).at(0.1).vx_mps, 1e-5);
  warm.air.temperature_c = 35.0;
  CHECK(Flight(warm, kStart, 100.0).at(0.1).vx_mps > expected + 0.01);
}

TEST(RigFlight, FindsWhenItPassedAPlace) {
  const Flight flight(scene_of({.drag = 0.55, .lift = true}), kStart, 100.0);
  for (const double x : {0.29, -0.1, -3.0, -15.0}) {
    const auto t = flight.time_back_at_x_s(x);
    CHECK(t && *t < 0.0);
    DOUBLES_EQUAL(x, flight.at(*t).x_m, 1e-11);
  }
}

TEST(RigFlight, LosesSpinByTheWayFlown) {
  // domega/dt = -c·|v|·omega: omega = omega0·exp(-c·way); the angle is its integral.
  Scene scene = scene_of({.density = 0.0});
  scene.air.spin_decay_per_m = 0.05;
  const Flight flight(scene, kStart, 200.0, Model::full().without(Effect::gravity));
  const double rate = 0.05 * kSpeed_mps;
  for (const double t : {-0.3, -0.01, 0.0, 0.02, 0.5}) {
    DOUBLES_EQUAL(200.0 * std::exp(-rate * t), flight.at(t).omega_radps, 1e-9);
    DOUBLES_EQUAL(-200.0 / rate * std::expm1(-rate * t), flight.at(t).rotation_rad, 1e-9);
  }
}

TEST(RigFlight, HasOnlyWhatTheModelHas) {
  const Scene scene = scene_of({.drag = 0.55, .lift = true});
  const FlightState bare = Flight(scene, kStart, 200.0, Model::none()).at(0.1);
  DOUBLES_EQUAL(kStart.x_m + 1.5, bare.x_m, 1e-14);
  DOUBLES_EQUAL(kStart.y_m - 0.6, bare.y_m, 1e-14);
  DOUBLES_EQUAL(20.0, bare.rotation_rad, 1e-13);
  const auto with = [&](Effect effect) {
    return Flight(scene, kStart, 200.0, Model::none().with(effect)).at(0.1);
  };
  DOUBLES_EQUAL(bare.y_m - 0.005 * kGravity_mps2, with(Effect::gravity).y_m, 1e-14);
  CHECK(with(Effect::drag).x_m < bare.x_m - 1e-3);
  CHECK(with(Effect::magnus).y_m > bare.y_m + 1e-3);
  CHECK(with(Effect::spin_decay).rotation_rad < bare.rotation_rad - 1e-3);
  DOUBLES_EQUAL(bare.x_m, with(Effect::spin_decay).x_m, 1e-14);
}

TEST(RigFlight, InstantsSideBySideAreThoseOfOneToTheLastBit) {
  Scene scene = scene_of({.drag = 0.55, .lift = true});
  scene.air.spin_decay_per_m = 0.03;
  const Flight flight(scene, kStart, -250.0), falling(scene_of({.density = 0.0}), kStart, -250.0);
  // Near each other; with as many steps; with more steps for some; before and after the start.
  for (const Flight::Instants& times : {Flight::Instants{0.031, 0.0311, 0.0312, 0.0313},
                                        {-0.2, -0.1999, -0.1998, -0.1997},
                                        {0.0, 1e-6, 2e-6, 3e-6},
                                        {0.0019999, 0.002, 0.0020001, 0.3},
                                        {-1e-6, 0.0, 0.1, -0.1}}) {
    for (const Flight* each : {&flight, &falling}) {
      const auto together = each->at(times);
      for (std::size_t i = 0; i < times.size(); ++i) {
        const FlightState alone = each->at(times[i]);
        DOUBLES_EQUAL(alone.x_m, together[i].x_m, 0.0);
        DOUBLES_EQUAL(alone.y_m, together[i].y_m, 0.0);
        DOUBLES_EQUAL(alone.vx_mps, together[i].vx_mps, 0.0);
        DOUBLES_EQUAL(alone.vy_mps, together[i].vy_mps, 0.0);
        DOUBLES_EQUAL(alone.omega_radps, together[i].omega_radps, 0.0);
        DOUBLES_EQUAL(alone.rotation_rad, together[i].rotation_rad, 0.0);
      }
    }
  }
}

TEST(RigFlight, IsRoughlyWhereItIsWithinACentimetreInAnyAir) {
  for (const double density : {0.1, 1.2, 12.0}) {
    for (const double speed : {1.0, 15.0, 60.0}) {
      for (const double spin : {-600.0, 0.0, 600.0}) {
        const FlightState start{0.3, 0.2, 0.6 * speed, 0.8 * speed};
        const Flight flight(scene_of({.drag = 0.6, .lift = true, .density = density}), start, spin);
        for (const double t : {0.005, 0.05, 0.25, 0.6}) {
          const FlightState exact = flight.at(t), rough = flight.roughly_at(t);
          CHECK(std::hypot(rough.x_m - exact.x_m, rough.y_m - exact.y_m) < 0.01);
        }
      }
    }
  }
}

// Without air the way up and down is a parabola's; in it the path is back at its start's height to its last digits.
TEST(RigFlight, ComesDownToTheHeightOfItsStart) {
  const FlightState rising{0.3, 0.2, 5.0, 4.0};
  const auto plain = Flight(scene_of({.density = 0.0}), rising, 100.0).time_back_down_s();
  DOUBLES_EQUAL(8.0 / kGravity_mps2, plain.value(), 1e-14);
  const Flight flight(scene_of({.drag = 0.55, .lift = true}), rising, 100.0);
  const double time_s = flight.time_back_down_s().value();
  DOUBLES_EQUAL(0.2, flight.at(time_s).y_m, 1e-14);
  CHECK(flight.at(time_s).vy_mps < 0.0);
  CHECK_FALSE(Flight(scene_of({.density = 0.0}), {0.3, 0.2, 5.0, 12.0}, 0.0).time_back_down_s().has_value());
}
