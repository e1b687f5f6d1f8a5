// Exchanges with a simulated camera whose clock and delays are known.
#include "host/clock/camera_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::host;

namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Truth: the camera's clock as a line of this machine's, rounded down.
struct SimulatedCamera {
  double ahead_ns = 3.7e12, drift = 50e-6;
  std::int64_t resolution_ns = 8;

  std::int64_t stamp_ns(std::int64_t host_ns) const {
    const double exact = ahead_ns + drift * static_cast<double>(host_ns);
    const auto camera_ns = host_ns + std::llround(exact);
    return camera_ns - camera_ns % resolution_ns;
  }
  ClockExchange exchange(std::int64_t sent_ns, std::int64_t there_ns, std::int64_t back_ns) const {
    return {from_ns<HostTime>(sent_ns), from_ns<HostTime>(sent_ns + there_ns + back_ns),
            stamp_ns(sent_ns + there_ns)};
  }
};

}  // namespace

TEST_GROUP(CameraClock) {
  SimulatedCamera camera;
  std::mt19937 engine{20261127};  // fixed

  std::int64_t drawn_ns(double mean_ns) {
    return std::llround(std::exponential_distribution<double>(1.0 / mean_ns)(engine));
  }
  double error_ns(const CameraClock& clock, std::int64_t host_ns) const {
    return static_cast<double>(to_ns(clock.local(camera.stamp_ns(host_ns))->instant) - host_ns);
  }
};

TEST(CameraClock, KnowsNothingBeforeTheFirstExchange) { CHECK_FALSE(CameraClock().local(5).has_value()); }

TEST(CameraClock, OneExchangeTellsTheInstantToItsOwnLength) {
  CameraClock clock;
  clock.on_exchange(camera.exchange(kSecond_ns, 30'000, 170'000));
  const auto instant = clock.local(camera.stamp_ns(kSecond_ns));
  // Anywhere within 200 us, and what reading and rounding take: the middle, 100 us after it was sent.
  DOUBLES_EQUAL(200'000.0 / std::sqrt(12.0), static_cast<double>(instant->sd.count()), 100.0);
  DOUBLES_EQUAL(70'000.0, error_ns(clock, kSecond_ns), 250.0);
}

TEST(CameraClock, TruthIsNeverFartherThanStatedHoweverDelaysAreDivided) {
  for (const double share_back : {0.02, 0.3, 0.5, 0.9}) {
    CameraClock clock(Duration{camera.resolution_ns});
    double squares = 0.0, sum_us = 0.0;
    int count = 0;
    for (std::int64_t at_ns = kSecond_ns; at_ns < 300 * kSecond_ns; at_ns += kSecond_ns) {
      const std::int64_t there_ns = 40'000 + drawn_ns(200'000.0 * (1.0 - share_back));
      const std::int64_t back_ns = 40'000 + drawn_ns(200'000.0 * share_back);
      const std::int64_t held_up_ns = engine() % 10 == 0 ? drawn_ns(5e7) : 0;  // by this machine
      clock.on_exchange(camera.exchange(at_ns, there_ns, back_ns + held_up_ns));
      if (at_ns < 10 * kSecond_ns) continue;
      const std::int64_t exposed_ns = at_ns + kSecond_ns / 2;
      const auto told = clock.local(camera.stamp_ns(exposed_ns));
      const double error_in_sds = error_ns(clock, exposed_ns) / static_cast<double>(told->sd.count());
      // The edge of an even distribution is sqrt(3) of its sds away from the middle.
      CHECK_TRUE(std::abs(error_in_sds) <= std::sqrt(3.0) + 1e-3);
      squares += error_in_sds * error_in_sds;
      sum_us += to_microseconds(told->sd);
      ++count;
    }
    CHECK_TRUE(squares / count < 3.0);
    // The best of thirty exchanges took some 100 us, which alone says 29 us; the instant lies half a second
    // on.
    CHECK_TRUE(sum_us / count < 50.0);
    LONGS_EQUAL(0, clock.restarts());
  }
}

TEST(CameraClock, DriftIsLearntSoThatAnInstantBetweenExchangesStaysSharp) {
  camera.drift = -180e-6;
  CameraClock clock(Duration{camera.resolution_ns});
  for (int i = 0; i < 30; ++i) clock.on_exchange(camera.exchange((1 + i) * kSecond_ns, 10'000, 10'000));
  // Two seconds on, unknown drift alone would leave 2 s * 1000 ppm = 2 ms. Bounds of +-10 us over 29 s leave
  // 0.7 ppm, and the wander of a crystal adds 0.1 ppm for each of 30 s.
  const auto told = clock.local(camera.stamp_ns(32 * kSecond_ns));
  CHECK_TRUE(told->sd < microseconds{15});
  CHECK_TRUE(std::abs(error_ns(clock, 32 * kSecond_ns)) < 15'000.0);
}

TEST(CameraClock, ExchangesThatTakeNoTimeDoNotContradictEachOther) {
  // As in a simulated rig, whose time stands still while programs run; a coarse clock, 1 us.
  camera.resolution_ns = 1000;
  CameraClock clock(Duration{camera.resolution_ns});
  for (int i = 0; i < 100; ++i) {
    clock.on_exchange(camera.exchange((1 + i) * kSecond_ns + i * 777, 0, 0));
    const std::int64_t exposed_ns = (1 + i) * kSecond_ns + 12'345;
    // Rounding, 1 us of the exchange and 1 us of the stamp, and 0.1 us of reading.
    CHECK_TRUE(i == 0 || std::abs(error_ns(clock, exposed_ns)) < 2'300.0);
  }
  LONGS_EQUAL(0, clock.restarts());
}

TEST(CameraClock, CameraThatWasStartedAnewBeginsANewRelation) {
  CameraClock clock;
  for (int i = 1; i < 40; ++i) clock.on_exchange(camera.exchange(i * kSecond_ns, 50'000, 50'000));
  camera.ahead_ns = -40e9;
  clock.on_exchange(camera.exchange(41 * kSecond_ns, 50'000, 50'000));
  LONGS_EQUAL(1, clock.restarts());
  CHECK_TRUE(std::abs(error_ns(clock, 41 * kSecond_ns)) < 50'300.0);
}

TEST(CameraClock, StepOfAMillisecondIsNoticed) {
  CameraClock clock;
  for (int i = 1; i < 40; ++i) clock.on_exchange(camera.exchange(i * kSecond_ns, 50'000, 50'000));
  camera.ahead_ns += 2e6;  // more than 1000 ppm of a second and what two exchanges leave open
  clock.on_exchange(camera.exchange(40 * kSecond_ns, 50'000, 50'000));
  LONGS_EQUAL(1, clock.restarts());
  CHECK_TRUE(std::abs(error_ns(clock, 40 * kSecond_ns)) < 50'300.0);
}
