// Frames reduced with covariance per second, on one core.
#include <benchmark/benchmark.h>

#include <random>

#include "common/messages/json_conversions.hpp"
#include "common/reduction/reduce.hpp"

namespace {

using namespace strobe::reduction;

/// A 23 degree bounce as a person digitizes it: five images before, one in contact, five after.
Frame typical_frame(bool labels, bool noise_stated) {
  constexpr double kScale = 4000.0;
  constexpr double kPeriod = 3e-3;
  constexpr double kRadius = 0.0651 / 2;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Frame frame;
  frame.shot_id = 1;
  frame.ball_diameter_m = 2 * kRadius;
  frame.ball_diameter_sd_m = 0.0008;
  frame.temperature_c = 21.0;
  for (const double x : {-800.0, -400.0, 700.0, 1000.0})
    frame.surface_px.push_back({x, 2.0 * normal(random)});
  const auto add = [&](int flash, Leg leg, double x, double y, double angle) {
    BallImage image;
    image.time_s = flash * kPeriod;
    if (labels) image.leg = leg;
    image.centre_px = {x * kScale + 2.0 * normal(random), y * kScale + 2.0 * normal(random)};
    image.diameter_px = 2 * kRadius * kScale + 3.0 * normal(random);
    image.equator_rad = angle + 0.017 * normal(random);
    frame.images.push_back(image);
  };
  for (int i = 0; i < 5; ++i) {
    const double t = (i - 4.4) * kPeriod;
    add(i, Leg::incoming, 15.62 * t, kRadius - 6.71 * t, 0.3 + 2.6 * t);
  }
  add(5, Leg::contact, 0.024, kRadius - 0.010, 0.2);
  for (int i = 6; i < 11; ++i) {
    const double t = (i - 4.4) * kPeriod - 5.2e-3;
    add(i, Leg::rebound, 0.063 + 8.84 * t, kRadius + 5.76 * t, 0.1 - 313.0 * t);
  }
  if (noise_stated) {
    frame.centre_sd_px = 2.0;
    frame.diameter_sd_px = 3.0;
    frame.equator_sd_rad = 0.017;
  }
  return frame;
}

void run(benchmark::State& state, Estimator estimator, bool labels, bool noise_stated) {
  const Frame frame = typical_frame(labels, noise_stated);
  for (auto _ : state) benchmark::DoNotOptimize(reduce(frame, estimator));
  state.SetItemsProcessed(state.iterations());
}

void best(benchmark::State& state) { run(state, Estimator::best, true, true); }
void best_legs_found(benchmark::State& state) { run(state, Estimator::best, false, true); }
void best_noise_estimated(benchmark::State& state) { run(state, Estimator::best, true, false); }
void two_point(benchmark::State& state) { run(state, Estimator::two_point, true, true); }
void legacy(benchmark::State& state) { run(state, Estimator::legacy, true, true); }

void frame_from_json(benchmark::State& state) {
  const std::string text = strobe::messages::frame_to_json(typical_frame(true, true));
  for (auto _ : state) benchmark::DoNotOptimize(strobe::messages::frame_from_json(text));
  state.SetItemsProcessed(state.iterations());
}

BENCHMARK(best);
BENCHMARK(best_legs_found);
BENCHMARK(best_noise_estimated);
BENCHMARK(two_point);
BENCHMARK(legacy);
BENCHMARK(frame_from_json);

}  // namespace
