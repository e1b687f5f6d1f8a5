// From a shot and its frame message to the readout, as strobe does it when a frame arrives.
// Percentiles are of single shots: a mean would hide the machine's pauses.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "host/assembly/assemble.hpp"
#include "tests/host/synthetic_shot.hpp"

namespace {

using namespace strobe;
using Clock = std::chrono::steady_clock;

host_test::SyntheticShot shot_of_kind(int kind, std::uint32_t seed) {
  host_test::Scenario scenario;
  scenario.seed = seed;
  const int around = host_test::last_flash_before_touchdown(scenario);
  if (kind == 1) scenario.late_us[around - 1] = 160;
  if (kind == 2)  // every flash late by another amount
    for (int k = 0; k < scenario.flash_count; ++k) scenario.late_us[k] = static_cast<double>((k * 37) % 91);
  return host_test::make_shot(scenario);
}

void frame_to_readout(benchmark::State& state) {
  std::vector<host_test::SyntheticShot> shots;
  for (std::uint32_t seed = 1; seed <= 32; ++seed)
    shots.push_back(shot_of_kind(static_cast<int>(state.range(0)), seed));
  host::AssemblySettings settings;
  settings.machine_lag_s = host_test::kMachineLag_s;
  std::vector<double> took_us;
  std::size_t next = 0;
  for (auto _ : state) {
    const auto& made = shots[next++ % shots.size()];
    const auto start = Clock::now();
    benchmark::DoNotOptimize(host::shot_readout(made.shot, made.frame, settings));
    took_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
  std::sort(took_us.begin(), took_us.end());
  const auto percentile = [&](double p) {
    return took_us[static_cast<std::size_t>(p * static_cast<double>(took_us.size() - 1))];
  };
  state.counters["p50_us"] = percentile(0.50);
  state.counters["p99_us"] = percentile(0.99);
}

}  // namespace

BENCHMARK(frame_to_readout)->ArgName("kind")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond);
