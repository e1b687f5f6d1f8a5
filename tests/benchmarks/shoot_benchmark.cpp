// What a whole simulated shot costs, by model: all effects, none, and each effect taken away from all but
// pixels (which cost more than everything else together) or added to none. CPU time is the figure to read.
#include <benchmark/benchmark.h>

#include <string>

#include "sim/shoot/shoot.hpp"

namespace {

using namespace strobe::sim;

/// 17 m/s at 23 degrees, with every spread and every effect that a scene can have.
Scene typical_scene() {
  Scene scene;
  scene.name = "typical";
  scene.machine.angle_rad = -0.4;
  scene.machine.speed_sd_mps = 0.16;
  scene.machine.spin_sd_radps = 1.0;
  scene.bounce.e_speed_mps = 6.6;
  scene.bounce.e_sd = scene.bounce.mu_sd = scene.bounce.offset_share_sd = 0.02;
  scene.bounce.dwell_sd_s = 0.2e-3;
  scene.camera.distance_m = 1.5;
  scene.camera.off_plane_sd_m = 0.005;
  scene.camera.distortion = 0.02;
  scene.camera.pixels = true;
  return scene;
}

void shots(benchmark::State& state, const Model& model) {
  auto shooter = Shooter::make(typical_scene(), 1, model, {.perfect_digitizer = true});
  int shot = 0;
  std::size_t images = 0;
  for (auto _ : state) {
    const SimulatedShot result = shooter->shoot(++shot);
    images += result.frame.images.size();
    benchmark::DoNotOptimize(result);
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["images"] =
      benchmark::Counter(static_cast<double>(images), benchmark::Counter::kAvgIterations);
}

void prepare(benchmark::State& state, const Model& model) {
  const Scene scene = typical_scene();
  for (auto _ : state) benchmark::DoNotOptimize(Shooter::make(scene, 1, model));
}

const int registered = [] {
  const Model full = Model::full();
  const Model points = full.without(Effect::pixels);
  // The contact's effects each need the ones before it (sim/motion/contact_path.hpp).
  const Model algebraic = points.without(Effect::contact_ode).without(Effect::tangential_compliance);
  benchmark::RegisterBenchmark("shot/full", shots, full);
  benchmark::RegisterBenchmark("shot/full_but_pixels", shots, points);
  benchmark::RegisterBenchmark("shot/none", shots, Model::none());
  for (const std::string_view effect_name : kEffectNames) {
    const Effect effect = *effect_from_name(effect_name);
    const std::string name(effect_name);
    const bool of_ode = effect == Effect::tangential_compliance || effect == Effect::grip;
    const Model less = of_ode ? algebraic.without(effect) : points.without(effect);
    if (effect != Effect::pixels) benchmark::RegisterBenchmark(("without/" + name).c_str(), shots, less);
    benchmark::RegisterBenchmark(("only/" + name).c_str(), shots, Model::none().with(effect));
  }
  benchmark::RegisterBenchmark("prepare/full", prepare, full);
  benchmark::RegisterBenchmark("prepare/calibrated", prepare, algebraic);
  return 0;
}();

}  // namespace
