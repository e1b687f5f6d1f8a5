// Heartbeats of a simulated firmware whose clock, delays and machine are known.
#include "host/clock/device_clock.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "tests/host/heartbeats.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::host;
using strobe::host_test::Heartbeats;

namespace {

constexpr Duration kSecond = std::chrono::seconds{1};

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
  CHECK_FALSE(clock.local(5, from_ns(5)).has_value());
  LONGS_EQUAL(0, clock.state().heartbeats);
}

TEST(DeviceClock, StandsOnTheFastestMessageUntilThereAreEnough) {
  Heartbeats beats(1);
  play(beats, 2);
  CHECK_FALSE(clock.state().drift_ppm.has_value());
  play(beats, 8);
  const double error_s = to_seconds(*clock.local(beats.boot_id, beats.device()) - beats.local());
  CHECK(error_s > 0.0 && error_s < 0.001);  // the delay that all messages have
  play(beats, 30);
  CHECK(clock.state().drift_ppm.has_value());
}

TEST(DeviceClock, IsNotBrokenByALateFirstMessage) {
  Heartbeats beats(13);
  beats.extra_delay_s = 0.02;
  play(beats, 2);
  beats.extra_delay_s = 0.0;
  play(beats, 60);
  LONGS_EQUAL(62, clock.state().heartbeats);
  CHECK_EQUAL(0u, clock.take_notifications().size());
  CHECK(abs(*clock.local(beats.boot_id, beats.device()) - beats.local()) < microseconds{200});
}

TEST(DeviceClock, IsNotMovedByABurstOfDelay) {
  Heartbeats beats(3);
  play(beats, 200);
  const MonoTime probe = beats.device();
  const HostTime before = *clock.local(beats.boot_id, probe);
  beats.extra_delay_s = 0.2;  // the host did not come round for 5 s
  play(beats, 10);
  beats.extra_delay_s = 0.0;
  play(beats, 1);
  CHECK(abs(*clock.local(beats.boot_id, probe) - before) < microseconds{50});
  CHECK(clock.state().worst_latency_s > 0.19);
  CHECK(std::abs(*clock.state().latency_s) < 0.001);
  CHECK_EQUAL(0u, clock.take_notifications().size());
}

TEST(DeviceClock, PassesOverMessagesThatWereOvertaken) {
  Heartbeats beats(4);
  play(beats, 50);
  const HostTime local = *clock.local(beats.boot_id, beats.device());
  clock.on_heartbeat(beats.boot_id, {beats.device() - kSecond, {}, {}}, beats.local());
  LONGS_EQUAL(50, clock.state().heartbeats);
  CHECK_EQUAL(local, *clock.local(beats.boot_id, beats.device()));
}

TEST(DeviceClock, TellsThatAWallClockWasSetAndGoesOnUnmoved) {
  Heartbeats beats(5);
  play(beats, 100);
  const MonoTime probe = beats.device();
  const HostTime before = *clock.local(beats.boot_id, probe);
  beats.device_wall += 3600 * kSecond;
  play(beats, 9);
  STRCMP_CONTAINS("the wall clock of the rig's computer was set by +3600.0 s",
                  joined(clock.take_notifications()).c_str());
  LONGS_EQUAL(109, clock.state().heartbeats);
  CHECK(abs(*clock.local(beats.boot_id, probe) - before) < microseconds{100});
  clock.on_local({});
  clock.on_local({HostTime{kSecond}, WallTime{-7 * kSecond}, kSecond});
  STRCMP_CONTAINS("the wall clock of this computer was set by -8.0 s",
                  joined(clock.take_notifications()).c_str());
}

TEST(DeviceClock, BeginsAnewWhenTheFirmwaresMachineWasSuspended) {
  Heartbeats beats(6);
  play(beats, 100);
  const MonoTime before = beats.device();
  const HostTime before_local = *clock.local(beats.boot_id, before);
  beats.suspend(60.0);
  play(beats, 1);
  STRCMP_CONTAINS("the rig's computer was suspended for 60.0 s",
                  joined(clock.take_notifications()).c_str());
  LONGS_EQUAL(1, clock.state().heartbeats);
  CHECK(clock.suspended_within(beats.boot_id, before - kSecond, beats.device()));
  CHECK_FALSE(clock.suspended_within(beats.boot_id, before - 2 * kSecond, before - kSecond));
  CHECK_EQUAL(before_local, *clock.local(beats.boot_id, before));  // instants from before are told as before
  CHECK(abs(*clock.local(beats.boot_id, beats.device()) - beats.local()) < milliseconds{5});
}

TEST(DeviceClock, BeginsAnewWhenThisMachineWasSuspended) {
  Heartbeats beats(7);
  play(beats, 100);
  beats.local_offset -= 60 * kSecond;  // its clock stood still: messages come a minute too early
  play(beats, 1);
  STRCMP_CONTAINS("no longer agrees", joined(clock.take_notifications()).c_str());
  CHECK(abs(*clock.local(beats.boot_id, beats.device()) - beats.local()) < milliseconds{5});
}

TEST(DeviceClock, BeginsAnewWhenAllMessagesComeLateByTheSame) {
  Heartbeats beats(8);
  play(beats, 100);
  beats.local_offset += 3 * kSecond;
  play(beats, 7);
  CHECK_EQUAL(0u, clock.take_notifications().size());
  play(beats, 1);
  STRCMP_CONTAINS("no longer agrees", joined(clock.take_notifications()).c_str());
  LONGS_EQUAL(8, clock.state().heartbeats);
}

TEST(DeviceClock, GoesOnWhenTheFirmwareIsStartedAnew) {
  Heartbeats beats(9);
  play(beats, 100);
  beats.boot_id = 77;
  play(beats, 10);
  LONGS_EQUAL(110, clock.state().heartbeats);
  CHECK_EQUAL(0u, clock.take_notifications().size());
}

TEST(DeviceClock, BeginsAnewWhenTheFirmwaresMachineIsStartedAnew) {
  Heartbeats beats(10);
  play(beats, 100);
  beats.suspend(60.0);
  play(beats, 1);
  CHECK(clock.suspended_within(beats.boot_id, {}, beats.device()));
  const std::int64_t before = beats.boot_id;
  beats.reboot();
  play(beats, 60);
  LONGS_EQUAL(60, clock.state().heartbeats);
  CHECK(clock.suspended_within(before, {}, MonoTime::max()));
  CHECK_FALSE(clock.suspended_within(beats.boot_id, {}, MonoTime::max()));  // that was before
  CHECK(abs(*clock.local(beats.boot_id, beats.device()) - beats.local()) < milliseconds{5});
  CHECK_FALSE(clock.state().suspect);
}

TEST(DeviceClock, TellsInstantsOfABootByItsOwnClockHoweverManyFollow) {
  Heartbeats first(20);
  play(first, 100);
  const MonoTime probe = first.device();
  const HostTime before = *clock.local(first.boot_id, probe);
  Heartbeats below(21), above(22);
  below.boot_id = 6;
  below.reboot_to(3.0, first.local());
  play(below, 60);
  above.boot_id = 7;
  above.reboot_to(1e6, below.local());  // another machine stands in, which has run for days
  play(above, 60);
  CHECK_EQUAL(before, *clock.local(first.boot_id, probe));
  for (const Heartbeats* beats : {&below, &above})
    CHECK(abs(*clock.local(beats->boot_id, beats->device()) - beats->local()) < milliseconds{1});
  LONGS_EQUAL(60, clock.state().heartbeats);
  CHECK_EQUAL(0u, clock.take_notifications().size());
}

TEST(DeviceClock, IsNotMovedByWhatAnEarlierBootSentAndComesLate) {
  Heartbeats first(23), late(23), second(24);
  play(first, 100);
  DeviceClock alone;
  for (int i = 0; i < 100; ++i) late.send(alone);
  second.boot_id = 6;
  second.reboot_to(3.0, first.local());
  for (int i = 0; i < 60; ++i) {
    play(second, 1);
    if (i % 4 == 0) play(first, 1);
  }
  CHECK(abs(*clock.local(second.boot_id, second.device()) - second.local()) < milliseconds{1});
  CHECK(abs(*clock.local(first.boot_id, late.device()) - late.local()) < milliseconds{1});
  LONGS_EQUAL(60, clock.state().heartbeats);
}

TEST(DeviceClock, KnowsNothingOfABootThatWasNotHeard) {
  Heartbeats beats(25);
  play(beats, 10);
  CHECK_FALSE(clock.local(beats.boot_id + 1, beats.device()).has_value());
  CHECK_FALSE(clock.suspended_within(beats.boot_id + 1, {}, MonoTime::max()));
}

TEST(DeviceClock, RemembersABoundedNumberOfBoots) {
  Heartbeats beats(26);
  beats.boot_id = 1000;  // each later boot has a smaller number
  for (std::size_t i = 0; i <= DeviceClock::kMaxBoots; ++i, --beats.boot_id) play(beats, 1);
  CHECK_FALSE(clock.local(1000, beats.device()).has_value());
  CHECK(clock.local(999, beats.device()).has_value());
  CHECK(clock.local(beats.boot_id + 1, beats.device()).has_value());
}

TEST(DeviceClock, TellsThatTheMachineSleptBetweenTwoStartsOfTheFirmware) {
  Heartbeats beats(27);
  play(beats, 100);
  beats.suspend(60.0);
  beats.boot_id = 6;
  play(beats, 5);
  STRCMP_CONTAINS("the rig's computer was suspended for 60.0 s",
                  joined(clock.take_notifications()).c_str());
  CHECK(abs(*clock.local(6, beats.device()) - beats.local()) < milliseconds{5});
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

// Of 100 pairs of clocks instants were off by -5 to +87 us, the fastest messages' delay, and drifts by 0.9 ppm at most.
TEST(DeviceClock, TellsInstantsThroughLossesBurstsAndWander) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    Heartbeats beats(seed);
    beats.drift = 1e-6 * (static_cast<double>(seed) - 50.0);
    beats.lost_share = 0.05, beats.long_share = 0.15, beats.burst_share = 0.02;
    beats.wander = seed % 2 == 0 ? 0.05e-6 : 0.0;
    DeviceClock heard;
    for (int i = 0; i < 250; ++i) beats.send(heard);
    const double late_s = to_seconds(*heard.local(beats.boot_id, beats.device()) - beats.local());
    CHECK(std::abs(late_s) < Heartbeats::kDelay_s + Heartbeats::kJitter_s);
    DOUBLES_EQUAL(1e6 * beats.drift, *heard.state().drift_ppm, 2.0);
  }
}
