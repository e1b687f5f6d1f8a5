#include "sim/plan/flight_bounds.hpp"

#include <cmath>
#include <vector>

#include "sim/plan/corners.hpp"
#include "sim/plan/nominal_shot.hpp"
#include "tests/sim/plan/random_scene.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

namespace {

struct Extreme {
  Scene scene;
  std::vector<double> times_s;
};

Scene base() {
  Scene scene;
  scene.machine.speed_mps = 17.0;
  scene.machine.angle_rad = -0.4;
  scene.bounce.e_speed_mps = 6.6;
  return scene;
}

/// Everyday, fast, slow and steep, light in dense air, spun to the limit, on a slope.
std::vector<Extreme> extremes() {
  std::vector<Extreme> all(6, {base(), {0.0, 1e-3, 10e-3, 30e-3}});
  all[1].scene.machine.speed_mps = 60.0;
  all[2].scene.machine = {.speed_mps = 2.0, .angle_rad = -1.4};
  all[2].times_s = {0.05, 0.2};
  all[3].scene.ball.mass_kg = 0.01;
  all[3].scene.air.density_kgpm3 = 3.0;
  all[4].scene.machine.spin_radps = 900.0;
  all[4].scene.air.spin_decay_per_m = 0.05;
  all[5].scene.surface_angle_rad = 0.3;
  all[5].scene.machine.spin_radps = -500.0;
  return all;
}

struct Rest {
  double x_m = 0.0, y_m = 0.0, equator_rad = 0.0;
};

/// What is left of the difference between two simulated paths when the known part is taken away.
Rest rest(const BallState& with, const BallState& without, const Displacement& by) {
  return {std::abs(with.x_m - without.x_m - by.x_m), std::abs(with.y_m - without.y_m - by.y_m),
          std::abs(with.equator_rad - without.equator_rad - by.equator_rad)};
}

constexpr Effect kFlight[] = {Effect::gravity, Effect::drag, Effect::magnus, Effect::spin_decay};
constexpr double kRounding = 1e-11;  // of the simulated paths' integration, metres and radians

void check_bound(const Extreme& extreme, Effect effect, const Model& others) {
  const FlightBounds bounds(extreme.scene);
  const ModelledScene with(extreme.scene, others.with(effect));
  const ModelledScene without(extreme.scene, others.without(effect));
  const auto a = NominalShot::make(with, {});
  const auto b = NominalShot::make(without, {});
  CHECK_TRUE(a.has_value() && b.has_value());
  for (const double t : extreme.times_s) {
    for (const bool rebounding : {false, true}) {
      const double at = rebounding ? a->dwell_s() + t : -t;
      const BoundedDisplacement d = bounds.of(effect, rebounding ? a->rebound() : a->incoming(), t);
      const Rest r = rest(a->path().at(at), b->path().at(at), d.by);
      CHECK_TRUE(r.x_m <= d.within.x_m + kRounding);
      CHECK_TRUE(r.y_m <= d.within.y_m + kRounding);
      CHECK_TRUE(r.equator_rad <= d.within.equator_rad + kRounding);
    }
  }
}

}  // namespace

TEST_GROUP(FlightBounds){};

TEST(FlightBounds, HoldForPathsSimulatedWithAndWithoutAnEffect) {
  for (const Extreme& extreme : extremes())
    for (const Effect effect : kFlight) check_bound(extreme, effect, Model::full());
}

TEST(FlightBounds, HoldWhicheverOfTheOtherEffectsAreThere) {
  for (const Extreme& extreme : extremes()) {
    for (unsigned others = 0; others < 16; ++others) {
      Model model = Model::full();
      for (unsigned i = 0; i < 4; ++i) model = model.with(kFlight[i], (others >> i & 1U) != 0);
      for (const Effect effect : kFlight) check_bound(extreme, effect, model);
    }
  }
}

TEST(FlightBounds, AreNearlyAllKnownOverAnEverydayLeg) {
  // 17 m/s, 15 ms: what gravity and drag do is known but for a few percent (q·v·t is .5 %).
  const FlightBounds bounds(base());
  for (const Effect effect : {Effect::gravity, Effect::drag}) {
    const BoundedDisplacement d = bounds.of(effect, {15.6, -6.7, 0.0}, 0.015);
    CHECK_TRUE(d.within.y_m < 0.05 * std::hypot(d.by.x_m, d.by.y_m));
  }
}

TEST(FlightBounds, AreNothingWhereTheSceneHasNotTheEffect) {
  Scene scene = base();
  scene.air.drag_coefficient = 0.0;
  scene.air.lift = false;
  scene.air.spin_decay_per_m = 0.0;
  const FlightBounds bounds(scene);
  for (const Effect effect : {Effect::drag, Effect::magnus, Effect::spin_decay, Effect::pixels}) {
    const BoundedDisplacement d = bounds.of(effect, {15.0, -6.0, 300.0}, 0.02);
    DOUBLES_EQUAL(0.0, std::abs(d.by.x_m) + std::abs(d.by.y_m) + d.within.x_m + d.within.equator_rad, 0.0);
  }
}

TEST(FlightBounds, AreInfiniteWhereTheAirLeavesNoBound) {
  Scene scene = base();
  scene.ball.mass_kg = 0.001;
  scene.air.density_kgpm3 = 50.0;
  CHECK_TRUE(std::isinf(FlightBounds(scene).of(Effect::drag, {50.0, -20.0, 0.0}, 0.1).within.x_m));
}
