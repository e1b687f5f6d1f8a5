// How a Raspberry Pi 5's PIO counts beside the kernel's clock, measured and taken out.
#include <vector>

#include "tests/firmware/rp1_hardware_bench.hpp"

using namespace strobe;
using namespace strobe::testing::rp1_hardware;

TEST_GROUP(Rp1HardwareDrift){};

TEST(Rp1HardwareDrift, TheDriftIsMeasuredOnAfterAnArmingThatExpired) {
  Bench bench(40e-6);
  bench.get_ready();
  bench.load(fs::Track::movers, kLongShutter);
  bench.load(fs::Track::lamps, kFlashes);
  bench.carry_out(fs::to_frame(fs::Arm{{2, 100}, fs::train_crc(kLongShutter, kFlashes), 0}));
  bench.turn_for(milliseconds(4000));  // it expires after one second
  LONGS_EQUAL(Phase::idle, bench.controller->phase());
  CHECK_TRUE(bench.hardware.clocks().drift_sd < 5e-6);
}

// ---- the gate ----

TEST(Rp1HardwareDrift, TheBlocksDriftIsMeasuredAndTakenOut) {
  std::mt19937 random(16);
  for (const double drift : {-50e-6, -7e-6, 0.0, 50e-6}) {
    Bench bench(drift, random());
    DOUBLES_EQUAL(60e-6, bench.hardware.clocks().drift_sd, 1e-9);
    bench.get_ready();
    bench.turn_for(milliseconds(5000));
    const auto clocks = bench.hardware.clocks();
    CHECK_TRUE(clocks.drift_sd < 1e-6);
    DOUBLES_EQUAL(drift, clocks.drift, 4.0 * clocks.drift_sd);
    bench.begin(pulses(0, 50, milliseconds(2), milliseconds(1), milliseconds(19)), {}, milliseconds(60));
    LONGS_EQUAL(CutCause::none, bench.play().cut);
    const std::vector<Seen> edges = seen(bench, fs::Track::movers);
    const Duration length = bench.block().time_of(edges.back().cycle) - bench.block().time_of(edges.front().cycle);
    DOUBLES_EQUAL(49 * 20e6 + 1e6, static_cast<double>(length.count()), 4.0 * clocks.drift_sd * 1e9 + 6.0);

    // Nothing of before the train, nor of a count that failed, is mixed with what is counted now.
    bench.flaky.share = 0.05;
    bench.turn_for(milliseconds(1000));
    bench.flaky.share = 0.0;
    bench.turn_for(milliseconds(10'000));
    DOUBLES_EQUAL(drift, bench.hardware.clocks().drift, 4.0 * bench.hardware.clocks().drift_sd);
    CHECK_TRUE(bench.hardware.clocks().drift_sd < 0.2e-6);  // it would have aged by as much
  }
}

TEST(Rp1HardwareDrift, ADriftIsWithinFourStandardDeviationsHoweverShortItWasMeasured) {
  std::mt19937 random(22);
  for (int i = 0; i < 150; ++i) {
    const double drift = std::uniform_real_distribution<double>(-50e-6, 50e-6)(random);
    Bench bench(drift, random());
    bench.turn_for((i % 10 + 3) * milliseconds(100) + (i % 15 == 0 ? milliseconds(1000) : Duration{}));
    DOUBLES_EQUAL(drift, bench.hardware.clocks().drift, 4.0 * bench.hardware.clocks().drift_sd);
  }
}

TEST(Rp1HardwareDrift, ADriftThatIsNoLongerMeasuredIsKnownLessAndLess) {
  Bench bench;
  bench.turn_for(milliseconds(5000));
  const double before = bench.hardware.clocks().drift_sd;
  bench.block().gone = true;
  bench.turn_for(milliseconds(10'000));
  CHECK_TRUE(bench.hardware.clocks().drift_sd > before + 0.1e-6);
  CHECK_TRUE(bench.hardware.clocks().drift_sd < 60e-6);
}

TEST(Rp1HardwareDrift, AClockThatNtpSteersAbortsNoTrain) {
  Bench bench;
  bench.get_ready();
  bench.turn_for(milliseconds(5000));
  bench.begin(pulses(0, 50, milliseconds(2), milliseconds(1), milliseconds(39)), kFlashes, milliseconds(60));
  bench.block().steer(23e-6 + 90e-6);
  LONGS_EQUAL(CutCause::none, bench.play().cut);
}

// ---- a block that does not obey ----
