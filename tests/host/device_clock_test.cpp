// Heartbeats of a simulated firmware whose clock, delays and machine are known.
#include "host/clock/device_clock.hpp"

#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "tests/host/heartbeats.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe::host;
using strobe::host_test::Heartbeats;

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

/// Errors, each with the sd that was stated for it.
struct Honesty {
  std::vector<double> errors, sds;
  void add(double error, double sd) {
    errors.push_back(error);
    sds.push_back(sd);
  }
  double mean() const {
    return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  }
  /// Root mean square about a centre, in stated sds.
  double rms(double centre) const {
    double squares = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) squares += std::pow((errors[i] - centre) / sds[i], 2);
    return std::sqrt(squares / static_cast<double>(errors.size()));
  }
};

std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

}  // namespace

TEST_GROUP(DeviceClock) {
  DeviceClock clock;

  void play(Heartbeats & beats, int count) {
    for (int i = 0; i < count; ++i) beats.send(clock);
  }
};

TEST(DeviceClock, KnowsNothingBeforeTheFirstHeartbeat) {
  CHECK_FALSE(clock.local_ns(5).has_value());
  LONGS_EQUAL(0, clock.state().heartbeats);
}

TEST(DeviceClock, StandsOnTheFastestMessageUntilThereAreEnough) {
  Heartbeats beats(1);
  play(beats, 10);
  CHECK_FALSE(clock.state().drift_ppm.has_value());
  const double error_s = static_cast<double>(*clock.local_ns(beats.device_ns()) - beats.local_ns()) * 1e-9;
  CHECK(error_s > 0.0 && error_s < 0.001);  // the delay that all messages have
}

TEST(DeviceClock, TellsOffsetAndDriftWithTrueSds) {
  // 300 pairs of clocks, each heard for 100 s with bursts of delay and lost packets. The rms of 300 standard
  // normal numbers is 1 ± 0.041: a stated sd that is true within 15 % is well inside 0.85 to 1.15.
  Honesty drift, offset;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Heartbeats beats(seed);
    beats.drift = 1e-6 * (static_cast<double>(seed % 100) - 50.0);
    beats.lost_share = 0.05;
    beats.long_share = 0.15;
    beats.burst_share = 0.01;
    DeviceClock heard;
    for (int i = 0; i < 200; ++i) beats.send(heard);
    beats.lost_share = 0.0;  // the offset is told of the newest heartbeat
    beats.send(heard);
    const ClockState state = heard.state();
    drift.add(*state.drift_ppm - 1e6 * beats.drift, state.drift_sd_ppm);
    offset.add(*state.offset_s - beats.offset_s(), state.offset_sd_s);
  }
  // The delay that all messages have is no error of the line: it cannot be told from the offset.
  std::printf("clock: rms of errors in stated sds: drift %.3f, offset %.3f; usual delay taken for %.1f us\n",
              drift.rms(0.0), offset.rms(offset.mean()), 1e6 * offset.mean());
  CHECK(drift.rms(0.0) > 0.85 && drift.rms(0.0) < 1.15);
  CHECK(offset.rms(offset.mean()) > 0.85 && offset.rms(offset.mean()) < 1.15);
  // 100 us ± 20 us, and the long delays that are not long enough to be told from these.
  CHECK(offset.mean() > 95e-6 && offset.mean() < 110e-6);
}

TEST(DeviceClock, IsNotMovedByABurstOfDelay) {
  Heartbeats beats(3);
  play(beats, 200);
  const double before_s = *clock.state().offset_s;
  beats.extra_delay_s = 0.2;  // the host did not come round for 5 s
  play(beats, 10);
  beats.extra_delay_s = 0.0;
  play(beats, 1);
  DOUBLES_EQUAL(before_s, *clock.state().offset_s, 100e-6);
  CHECK(clock.state().worst_latency_s > 0.19);
  CHECK(std::abs(*clock.state().latency_s) < 0.001);
  CHECK_EQUAL(0u, clock.take_notices().size());
}

TEST(DeviceClock, PassesOverMessagesThatWereOvertaken) {
  Heartbeats beats(4);
  play(beats, 50);
  const std::int64_t local_ns = *clock.local_ns(beats.device_ns());
  clock.on_heartbeat(beats.boot_id, {beats.device_ns() - kSecond, 0, 0}, beats.local_ns());
  LONGS_EQUAL(50, clock.state().heartbeats);
  CHECK_EQUAL(local_ns, *clock.local_ns(beats.device_ns()));
}

TEST(DeviceClock, TellsThatAWallClockWasSetAndGoesOnUnmoved) {
  Heartbeats beats(5);
  play(beats, 100);
  const std::int64_t probe_ns = beats.device_ns();
  const std::int64_t before_ns = *clock.local_ns(probe_ns);
  beats.device_wall_ns += 3600 * kSecond;
  play(beats, 9);
  STRCMP_CONTAINS("the wall clock of the firmware's machine was set by +3600.0 s",
                  joined(clock.take_notices()).c_str());
  LONGS_EQUAL(109, clock.state().heartbeats);
  CHECK(std::abs(*clock.local_ns(probe_ns) - before_ns) < 100'000);
  clock.on_local({0, 0, 0});
  clock.on_local({kSecond, -7 * kSecond, kSecond});
  STRCMP_CONTAINS("the wall clock of this machine was set by -8.0 s", joined(clock.take_notices()).c_str());
}

TEST(DeviceClock, BeginsAnewWhenTheFirmwaresMachineWasSuspended) {
  Heartbeats beats(6);
  play(beats, 100);
  const std::int64_t before_ns = beats.device_ns();
  const std::int64_t before_local_ns = *clock.local_ns(before_ns);
  beats.suspend(60.0);
  play(beats, 1);
  STRCMP_CONTAINS("the firmware's machine was suspended for 60.0 s", joined(clock.take_notices()).c_str());
  LONGS_EQUAL(1, clock.state().heartbeats);
  CHECK(clock.slept_within(before_ns - kSecond, beats.device_ns()));
  CHECK_FALSE(clock.slept_within(before_ns - 2 * kSecond, before_ns - kSecond));
  CHECK_EQUAL(before_local_ns, *clock.local_ns(before_ns));  // instants from before are told as before
  CHECK(std::abs(*clock.local_ns(beats.device_ns()) - beats.local_ns()) < 5'000'000);
}

TEST(DeviceClock, BeginsAnewWhenThisMachineWasSuspended) {
  Heartbeats beats(7);
  play(beats, 100);
  beats.local_offset_ns -= 60 * kSecond;  // its clock stood still: messages come a minute too early
  play(beats, 1);
  STRCMP_CONTAINS("do not go together any more", joined(clock.take_notices()).c_str());
  CHECK(std::abs(*clock.local_ns(beats.device_ns()) - beats.local_ns()) < 5'000'000);
}

TEST(DeviceClock, BeginsAnewWhenAllMessagesComeLateByTheSame) {
  Heartbeats beats(8);
  play(beats, 100);
  beats.local_offset_ns += 3 * kSecond;
  play(beats, 7);
  CHECK_EQUAL(0u, clock.take_notices().size());
  play(beats, 1);
  STRCMP_CONTAINS("do not go together any more", joined(clock.take_notices()).c_str());
  LONGS_EQUAL(8, clock.state().heartbeats);
}

TEST(DeviceClock, GoesOnWhenTheFirmwareIsStartedAnew) {
  Heartbeats beats(9);
  play(beats, 100);
  beats.boot_id = 77;
  play(beats, 10);
  LONGS_EQUAL(110, clock.state().heartbeats);
  CHECK_EQUAL(0u, clock.take_notices().size());
}

TEST(DeviceClock, BeginsAnewWhenTheFirmwaresMachineIsStartedAnew) {
  Heartbeats beats(10);
  play(beats, 100);
  beats.reboot();
  play(beats, 60);
  LONGS_EQUAL(60, clock.state().heartbeats);
  CHECK(std::abs(*clock.local_ns(beats.device_ns()) - beats.local_ns()) < 5'000'000);
  CHECK_FALSE(clock.state().suspect);
}

TEST(DeviceClock, FollowsADriftThatChanges) {
  Heartbeats beats(11);
  beats.drift = 20e-6;
  play(beats, 400);
  beats.change_drift(-30e-6);
  play(beats, 300);  // longer than the window
  DOUBLES_EQUAL(-30.0, *clock.state().drift_ppm, 1.0);
}

TEST(DeviceClock, SuspectsADriftThatNoClockHas) {
  Heartbeats beats(12);
  beats.drift = 2e-3;
  play(beats, 60);
  CHECK(clock.state().suspect);
}
