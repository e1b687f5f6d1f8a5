// Bursts that begin at the gate's edge, on a Raspberry Pi 5's PIO.
#include <vector>

#include "tests/firmware/rp1_hardware_bench.hpp"

using namespace strobe;
using namespace strobe::testing::rp1_hardware;

TEST_GROUP(Rp1HardwareGate){};

TEST(Rp1HardwareGate, AGatedBurstBeginsAtTheGatesEdge) {
  std::mt19937 random(15);
  for (int i = 0; i < 40; ++i) {
    const double drift = std::uniform_real_distribution<double>(-50e-6, 50e-6)(random);
    Bench bench(drift, random());
    bench.get_ready();
    bench.turn_for(milliseconds(1000));
    const auto burst = drawn_edges(random, 2, 40, microseconds(300));
    const MonoTime asked =
        bench.begin(kLongShutter, burst, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
    const MonoTime gate = asked + milliseconds(7) + bench.machine.draw({}, milliseconds(20));
    // The first one is too early; the third one is in the burst.
    for (const MonoTime edge : {asked + milliseconds(2), gate, gate + microseconds(20)}) {
      bench.machine.change(edge, Input::gate, true);
      bench.machine.change(edge + microseconds(10), Input::gate, false);
    }
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    CHECK_EQUAL(burst.size(), status.played[1]);
    check_edges(bench, fs::Track::movers, kLongShutter);
    check_edges(bench, fs::Track::lamps, burst);
    // The block's cycle in which the gate changed, and the drift of a first delay of 2.4 ms at most.
    const std::int64_t cycles = seen(bench, fs::Track::lamps).front().cycle - bench.block().cycle_of(gate);
    DOUBLES_EQUAL(burst.front().delay * 8.0 / 5.0 / (1.0 + bench.hardware.clocks().drift), static_cast<double>(cycles), 2.0);
    // The kernel's stamp of that edge, 1 to 9 us late.
    const std::int64_t late_ns = status.burst_started * kTick_ns - to_ns(gate);
    CHECK_TRUE(late_ns >= 1000 - kTick_ns && late_ns <= 9000);
  }
}

TEST(Rp1HardwareGate, AnEdgeWhileTheWindowOpensIsToldAsTheBurstIfItWas) {
  std::mt19937 random(19);
  int first = 0, second = 0;
  for (int i = 0; i < 200; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    const MonoTime asked =
        bench.begin(kLongShutter, kFlashes, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
    // The loop comes round in 0.8 ms, and its calls take up to 30 us each.
    std::array<MonoTime, 2> gate{asked + milliseconds(5) + bench.machine.draw({}, microseconds(1000))};
    gate[1] = gate[0] + microseconds(100);
    for (const MonoTime edge : gate) {
      bench.machine.change(edge, Input::gate, true);
      bench.machine.change(edge + microseconds(10), Input::gate, false);
    }
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    const std::vector<Seen> burst = seen(bench, fs::Track::lamps);
    if (burst.empty()) continue;
    const MonoTime began = bench.block().time_of(burst.front().cycle) - milliseconds(2);
    (began < gate[1] - microseconds(5) ? first : second) += 1;
    const std::int64_t late_ns = status.burst_started * kTick_ns - to_ns(began);
    CHECK_TRUE(late_ns >= 500 && late_ns <= 10'000);
  }
  CHECK_TRUE(first > 20 && second > 5);
}

TEST(Rp1HardwareGate, AnEdgeWhileTheWindowClosesLeavesNoOutputOn) {
  std::mt19937 random(20);
  const auto burst = pulses(2, 10, nanoseconds(128), milliseconds(1), milliseconds(1));
  int whole = 0, none = 0;
  for (int i = 0; i < 200; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    const MonoTime asked =
        bench.begin(kLongShutter, burst, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
    // As above.
    const MonoTime gate = asked + milliseconds(30) + bench.machine.draw({}, microseconds(1000));
    bench.machine.change(gate, Input::gate, true);
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    if (status.played[1] != 0) {
      check_edges(bench, fs::Track::lamps, burst);
      ++whole;
      continue;
    }
    ++none;
    const std::vector<Seen> edges = seen(bench, fs::Track::lamps);
    CHECK_TRUE(edges.empty() || (edges.size() == 2 && edges.back().levels == 0));
  }
  CHECK_TRUE(whole > 5 && none > 20);
}

TEST(Rp1HardwareGate, AGateOutsideOfItsWindowStartsNothing) {
  Bench bench;
  bench.get_ready();
  const MonoTime asked =
      bench.begin(kLongShutter, kFlashes, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
  for (const Duration after : {milliseconds(4), milliseconds(34)}) {
    bench.machine.change(asked + after, Input::gate, true);
    bench.machine.change(asked + after + milliseconds(2), Input::gate, false);
  }
  const fs::Status status = bench.play();
  LONGS_EQUAL(CutCause::none, status.cut);
  CHECK_EQUAL(2, status.played[0]);
  CHECK_EQUAL(0, status.played[1]);
  CHECK_TRUE(status.burst_started == fs::kNoTicks);
  CHECK_TRUE(seen(bench, fs::Track::lamps).empty());
}

// ---- clocks ----
