// Time of one contact, by method and tolerance, on one core: three shots of the thesis's kind (slides
// throughout, grips late, grips from nearly the start) in turn.
#include <benchmark/benchmark.h>

#include <array>

#include "common/impact/ode/contact_trajectory.hpp"

namespace {

using namespace strobe::impact;

struct Shot {
  Motion touchdown;
  ContactCoefficients coefficients;
};

const std::array<Shot, 3> kShots{{{{16.18, -5.08, 168.3}, {.e = 0.77, .dwell_s = 6.25e-3}},
                                  {{14.49, -9.95, -1.1}, {.e = 0.77, .dwell_s = 4.84e-3}},
                                  {{8.45, -15.29, -146.7}, {.e = 0.69, .dwell_s = 4.05e-3}}}};

const strobe::ball::Ball kBall{.alpha = kContactAlpha};

void run(benchmark::State& state, const ContactOptions& options) {
  std::size_t next = 0;
  for (auto _ : state) {
    const Shot& shot = kShots[next];
    next = (next + 1) % kShots.size();
    benchmark::DoNotOptimize(simulate(kBall, shot.touchdown, shot.coefficients, options));
  }
  state.SetItemsProcessed(state.iterations());
}

void adaptive(benchmark::State& state) {
  double tolerance = 1.0;
  for (int64_t i = 0; i < state.range(0); ++i) tolerance /= 10.0;
  run(state, {.tolerance = tolerance});
}

void rk4(benchmark::State& state) {
  run(state, {.method = ContactMethod::rk4, .steps = static_cast<int>(state.range(0))});
}

void semi_implicit_euler(benchmark::State& state) {
  run(state, {.method = ContactMethod::semi_implicit_euler, .steps = static_cast<int>(state.range(0))});
}

void trajectory_state(benchmark::State& state) {
  const auto contact = ContactTrajectory::make(kBall, kShots[1].touchdown, kShots[1].coefficients);
  double time = 0.0;
  for (auto _ : state) {
    time = time < 4.8e-3 ? time + 1e-6 : 0.0;
    benchmark::DoNotOptimize(contact->at(time));
  }
}

BENCHMARK(adaptive)->Name("adaptive_1e-")->Arg(6)->Arg(9)->Arg(12)->Unit(benchmark::kMicrosecond);
BENCHMARK(rk4)->Arg(50)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(semi_implicit_euler)->Arg(200)->Arg(2000)->Unit(benchmark::kMicrosecond);
BENCHMARK(trajectory_state);

}  // namespace
