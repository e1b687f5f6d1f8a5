// Closed-form impacts per second, on one core. The touchdowns vary from call to call, so that neither the
// branch predictor nor the compiler sees one case only.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>

#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"

namespace {

using namespace strobe;
using namespace strobe::impact;

struct Shot {
  Motion touchdown;
  double e, mu, dwell_s;
};

constexpr std::size_t kShots = 1024;

/// 15 to 75 degrees at 10 to 40 m/s with spins of either sign: slides and grips in turn.
const std::array<Shot, kShots>& shots() {
  static const std::array<Shot, kShots> all = [] {
    std::array<Shot, kShots> made{};
    std::mt19937_64 random(1);
    const auto between = [&random](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (Shot& s : made) {
      const double speed = between(10.0, 40.0), angle = between(0.26, 1.31);
      s = {{speed * std::cos(angle), -speed * std::sin(angle), between(-400.0, 400.0)},
           between(0.6, 0.95),
           between(0.4, 0.7),
           between(4e-3, 6e-3)};
    }
    return made;
  }();
  return all;
}

template <typename Model>
void run(benchmark::State& state, Model&& model) {
  const auto& all = shots();
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(model(all[i]));
    i = (i + 1) % kShots;
  }
  state.SetItemsProcessed(state.iterations());
}

PulseInput input_of(const Shot& s) {
  return {s.touchdown.vx_mps, s.touchdown.vy_mps, s.e, s.mu, s.dwell_s, ball::kThesisMass_kg};
}

void rigid_rebound(benchmark::State& state) {
  run(state, [](const Shot& s) { return rigid(ball::Ball{}, s.touchdown, s.e, s.mu); });
}

void grip_rebound(benchmark::State& state) {
  run(state, [](const Shot& s) {
    Coefficients c = kFittedToThesis;
    c.e = s.e;
    c.mu = s.mu;
    return grip(ball::Ball{}, s.touchdown, c);
  });
}

void pulse_make(benchmark::State& state, PulseForm form) {
  run(state, [form](const Shot& s) { return SinePulse::make(form, input_of(s)); });
}

void pulse_state(benchmark::State& state, PulseForm form) {
  const SinePulse pulse = *SinePulse::make(form, input_of(shots()[0]));
  run(state, [&pulse](const Shot& s) { return pulse.at_fraction(s.e); });
}

void pulse_rebound_of(benchmark::State& state, PulseForm form) {
  run(state,
      [form](const Shot& s) { return pulse_rebound(form, ball::Ball{}, s.touchdown, s.e, s.mu, s.dwell_s); });
}

BENCHMARK(rigid_rebound);
BENCHMARK(grip_rebound);
BENCHMARK_CAPTURE(pulse_make, exact, PulseForm::exact);
BENCHMARK_CAPTURE(pulse_make, simplified, PulseForm::simplified);
BENCHMARK_CAPTURE(pulse_state, exact, PulseForm::exact);
BENCHMARK_CAPTURE(pulse_state, simplified, PulseForm::simplified);
BENCHMARK_CAPTURE(pulse_rebound_of, exact, PulseForm::exact);
BENCHMARK_CAPTURE(pulse_rebound_of, simplified, PulseForm::simplified);

}  // namespace
