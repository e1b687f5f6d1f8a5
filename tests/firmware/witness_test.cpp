// A flash sequencer's stamps beside the kernel's own of the same edges.
#include "firmware/flash_sequencer/witness.hpp"

#include <cmath>
#include <cstdio>
#include <deque>
#include <random>

#include "tests/firmware/flash_sequencer_bench.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

namespace {

/// What the kernel stamped.
struct KernelStamps final : EdgeSource {
  std::deque<Edge> come;
  std::optional<std::size_t> wait(MonoTime, std::span<Edge> edges) noexcept override {
    std::size_t count = 0;
    for (; count < edges.size() && !come.empty(); come.pop_front()) edges[count++] = come.front();
    return count;
  }
  std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept override { return wait(until, edges); }
  std::optional<bool> level(Input) noexcept override { return std::nullopt; }
  std::int64_t kernel_overflows() const noexcept override { return 0; }
};

constexpr Duration kPeriod = milliseconds(3);
constexpr double kLate_ns = 2500.0, kLateSd_ns = 400.0;  // of the kernel's stamps: an interrupt's latency

}  // namespace

TEST_GROUP(Witness) {
  FlashSequencerBench bench;
  KernelStamps kernel;
  Witness witness{kernel, bench.link};
  std::mt19937_64 random{7};

  /// Until the drift is known.
  void setup() override {
    for (int i = 0; i < 1000; ++i) turn();
  }
  void turn() {
    bench.line.wait(bench.line.time + milliseconds(4));
    bench.link.take();
  }
  MonoTime shot() {
    const MonoTime begin = bench.line.time;
    bench.link.hold_clock_relation(begin + milliseconds(10'000));
    return begin;
  }
  /// One edge of sensor A, stamped by one or both.
  void edge(MonoTime at, bool by_sequencer, bool by_kernel) {
    const double late_ns = std::normal_distribution<double>(kLate_ns, kLateSd_ns)(random);
    if (by_sequencer) witness.note(Input::sensor_a, bench.line.chip.ticks(at));
    if (by_kernel) kernel.come.push_back({Input::sensor_a, at + Duration{std::llround(late_ns)}, true});
    witness.look();
  }
};

TEST(Witness, RelatesTheClockAsTheKernelStampsEdges) {
  const MonoTime begin = shot();
  constexpr int kEdges = 160;
  for (int i = 0; i < kEdges; ++i) edge(begin + i * kPeriod, true, true);
  const MonoTime next = shot();
  LONGS_EQUAL(kEdges, bench.link.agreement().count());
  // A scatter of n differences is known to 1/sqrt(2 n): five times that. To it comes a drift that may be off by .3 ppm
  // after four seconds, over .5 s.
  DOUBLES_EQUAL(kLateSd_ns, bench.link.agreement().sd(), 0.28 * kLateSd_ns + 50.0);
  const MonoTime told = bench.link.clock_relation().to_time(bench.line.chip.ticks(next));
  std::printf("told %.0f ns after the truth\n", static_cast<double>((told - next).count()));
  // 400 ns/sqrt(160) = 32 ns, five times that, a tick, and the drift over half of .5 s.
  DOUBLES_EQUAL(kLate_ns, static_cast<double>((told - next).count()), 160.0 + 8.0 + 75.0);
}

TEST(Witness, PairsWhatBothHaveStampedAlone) {
  const MonoTime begin = shot();
  for (int i = 0; i < 100; ++i) edge(begin + i * kPeriod, i % 10 != 3, i % 10 != 7);
  shot();
  LONGS_EQUAL(80, bench.link.agreement().count());
  CHECK(bench.link.agreement().sd() < 5000.0);  // none is of another flash, 3 ms away
}

TEST(Witness, IsNotHeardOnAFewEdges) {
  const MonoTime begin = shot();
  for (int i = 0; i < 19; ++i) edge(begin + i * kPeriod, true, true);
  shot();
  LONGS_EQUAL(0, bench.link.agreement().count());
}

TEST(Witness, AShotsTimesAreOfOneStraightLine) {
  const MonoTime begin = shot();
  const auto first = bench.line.chip.ticks(begin);
  const MonoTime before = bench.link.clock_relation().to_time(first);
  for (int i = 0; i < 500; ++i) {
    turn();
    CHECK(before == bench.link.clock_relation().to_time(first));
  }
}
