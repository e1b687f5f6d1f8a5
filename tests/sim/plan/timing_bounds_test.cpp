#include "sim/plan/timing_bounds.hpp"

#include <cmath>

#include "sim/plan/nominal_shot.hpp"
#include "sim/random/draws.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

namespace {

Scene scene_with_flash(double flash_s) {
  Scene scene;
  scene.machine.speed_mps = 30.0;
  scene.machine.spin_radps = 400.0;
  scene.bounce.e_speed_mps = 11.7;
  scene.lamps.flash_s = flash_s;
  return scene;
}

}  // namespace

TEST_GROUP(TimingBounds){};

TEST(TimingBounds, OfAFlashHoldForTheMeanOfTheSimulatedPathOverIt) {
  for (const double flash_s : {1e-6, 50e-6, 200e-6}) {
    const Scene scene = scene_with_flash(flash_s);
    const ModelledScene modelled(scene, Model::full());
    const auto shot = NominalShot::make(modelled, {});
    CHECK_TRUE(shot.has_value());
    const TimingBounds bounds(scene);
    // In flight, and with the flash's middle at touchdown and at lift-off.
    for (const double t : {-0.02, -0.003, -0.5 * flash_s, shot->dwell_s() - 0.5 * flash_s, 0.02}) {
      const bool rebounding = t > 0.5 * shot->dwell_s();
      const double from_surface = std::max(0.0, rebounding ? t - shot->dwell_s() : -t - flash_s);
      const LegMotion leg = rebounding ? shot->rebound() : shot->incoming();
      const BoundedDisplacement d = bounds.of(Effect::flash_duration, leg, from_surface);
      const BallState mean = shot->path().mean_over(t, flash_s);
      const BallState middle = shot->path().at(t + bounds.common_shift_s(Effect::flash_duration));
      CHECK_TRUE(std::abs(mean.x_m - middle.x_m) <= d.within.x_m + 1e-12);
      CHECK_TRUE(std::abs(mean.y_m - middle.y_m) <= d.within.y_m + 1e-12);
    }
  }
}

TEST(TimingBounds, OfJitterAreTheLargestDraws) {
  Scene scene;
  scene.lamps = {.delay_s = 10e-6, .jitter_s = 1e-6, .flash_s = 0.0};
  scene.sensors = {.delay_s = 5e-6, .jitter_s = 0.2e-6};
  const TimingBounds bounds(scene);
  DOUBLES_EQUAL(kLargestNormal * 1e-6, bounds.shift_s(Effect::lamp_jitter), 1e-18);
  DOUBLES_EQUAL(10e-6, bounds.common_shift_s(Effect::lamp_delay), 1e-18);
  // The constant part of the delay moves all times alike.
  DOUBLES_EQUAL(kLargestNormal * 0.2e-6, bounds.of(Effect::sensor_delay, {}, 0.0).within.time_s, 2e-9);
}

TEST(TimingBounds, OfTheShutterAreNothing) {
  const TimingBounds bounds{Scene{}};
  DOUBLES_EQUAL(0.0, bounds.shift_s(Effect::shutter_lag) + bounds.common_shift_s(Effect::shutter_lag), 0.0);
}
