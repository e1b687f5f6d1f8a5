// The session logic where the firmware is started anew: clocks of several boots, messages of earlier ones.
#include "common/messages/json_conversions.hpp"
#include "tests/host/session_bench.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host_test;

namespace {

/// A boot that follows, with its own clock; the earlier one is in its list.
struct Restarted : Bench {
  MonoTime began;
  explicit Restarted(MonoTime clock, std::int64_t host_id = 0) : Bench(host_id), began(clock) {}
  static constexpr std::int64_t kBoot = 6;  // less than the earlier one's

  void beat(double seconds) {
    status_t status{};
    status.boot_id = kBoot;
    status.mono_ns = status.boot_time_ns = status.wall_ns = to_ns(began + from_seconds(seconds));
    status.earlier.push_back({77, 1});
    status.earlier_count = 1;
    session.on_status(status, local + from_seconds(seconds));
  }
  void beat_until(double from_s, double to_s) {
    for (double t = from_s; t <= to_s; t += 0.5) beat(t);
  }
  /// Of the new boot: its shutter closes so long after the boot's first heartbeat.
  void shot_of_new_boot(double closed_s) {
    strobe_msgs::shot_t shot = made.shot;
    shot.boot_id = kBoot;
    shot.shutter_close_ns = to_ns(began + from_seconds(closed_s));
    shot.flashes.clear();
    session.on_shot(shot, local + from_seconds(closed_s));
  }
};

/// Smaller than the earlier boot's clock, about the same, larger by months.
const MonoTime kClocks[] = {MonoTime{30 * kSecond}, MonoTime{200 * kSecond}, MonoTime{10'000'000 * kSecond}};

}  // namespace

TEST_GROUP(SessionOfBoots){};

TEST(SessionOfBoots, ShotsOfBothBootsAreWaitedForByTheirOwnClocks) {
  for (const MonoTime clock : kClocks) {
    Restarted bench(clock);
    bench.shot();
    bench.beat_until(0.0, 2.0);
    bench.shot_of_new_boot(2.0);
    LONGS_EQUAL(2, bench.session.waiting_for_photograph());  // neither is over before the session was joined
    // The earlier boot was last heard half a second before its shot ended: 5.5 s of heartbeats from there.
    bench.beat_until(2.5, 5.5);
    CHECK_TRUE(bench.shot_results().empty());
    bench.beat(5.6);
    auto results = bench.shot_results();
    LONGS_EQUAL(1, results.size());
    LONGS_EQUAL(77, results[0].boot_id);
    bench.beat_until(6.0, 7.0);
    CHECK_TRUE(bench.shot_results().empty());
    bench.beat(7.1);
    results = bench.shot_results();
    LONGS_EQUAL(1, results.size());
    LONGS_EQUAL(Restarted::kBoot, results[0].boot_id);
    CHECK_TRUE(results[0].readout.flags.has(Flag::no_photograph));
  }
}

TEST(SessionOfBoots, ShotsOfANewBootAreReadOutByAPassiveHostWhateverTheClockOfTheOneBefore) {
  for (const MonoTime clock : kClocks) {
    Restarted bench(clock);
    bench.beat_until(0.0, 2.0);
    bench.shot_of_new_boot(2.0);
    bench.beat_until(2.5, 4.0);
    bench.made.frame.boot_id = Restarted::kBoot;
    bench.frame();
    LONGS_EQUAL(1, bench.shot_results().size());
  }
}

TEST(SessionOfBoots, WhatAnEarlierBootSentAndComesLateChangesNothing) {
  for (const MonoTime clock : kClocks) {
    Restarted bench(clock);
    bench.beat_until(0.0, 1.0);
    bench.session.take_notifications();
    bench.shot_of_new_boot(1.0);
    for (double t = 1.5; t <= 6.0; t += 0.5) {
      bench.beat(t);
      status_t late{};
      late.boot_id = 77;
      late.mono_ns = late.boot_time_ns = late.wall_ns = to_ns(bench.end + from_seconds(t));
      bench.session.on_status(late, bench.local + from_seconds(t));
      LONGS_EQUAL(Restarted::kBoot, bench.session.status()->boot_id);
    }
    CHECK_TRUE(bench.shot_results().empty());
    CHECK_TRUE(bench.session.take_notifications().empty());
    bench.beat(6.1);
    LONGS_EQUAL(1, bench.shot_results().size());
  }
}

TEST(SessionOfBoots, AStatusThatWasOvertakenChangesNothing) {
  Bench bench;
  bench.status(bench.end + kSecond);
  bench.status(bench.end);
  CHECK(bench.newest() == bench.end + kSecond);
}

TEST(SessionOfBoots, AShotOfABootThatEndedBeforeTheSessionWasJoinedIsNotWaitedFor) {
  Restarted bench(kClocks[2]);
  bench.beat(0.0);
  SyntheticShot other = bench.made;
  other.shot.boot_id = 5;
  status_t status = *bench.session.status();
  status.earlier.push_back({5, 10});
  status.earlier_count = 2;
  bench.session.on_status(status, bench.local);
  bench.session.on_shot(other.shot, bench.local);
  LONGS_EQUAL(0, bench.session.waiting_for_photograph());
}

TEST(SessionOfBoots, AnEarlierBootThatIsPlayedBackEndsNoShot) {
  // The firmware heard says that boot 76 came before it; of boot 75 neither says anything.
  for (const std::int64_t played_back : {76, 75}) {
    CutOff bench(5);
    status_t running{};
    running.boot_id = 77;
    running.mono_ns = running.boot_time_ns = running.wall_ns = to_ns(bench.end);
    running.earlier.push_back({76, 1000});
    running.earlier_count = 1;
    running.last_sequence = 4;
    running.arm_host_id = 5;
    bench.session.on_status(running, bench.local);
    // Eight requests for a tail that never comes would end an ended boot's shot.
    for (int i = 0; i < 100; ++i) {
      status_t old{};
      old.boot_id = played_back;
      old.mono_ns = old.boot_time_ns = to_ns(bench.end) + std::int64_t{i} * 500'000'000;
      bench.local += kSecond / 10;
      bench.session.on_status(old, bench.local);
      bench.session.on_time(bench.local);
      bench.session.ledger().due(bench.local);
      if (played_back == 75) {  // told apart by the one that is still heard
        running.mono_ns += 100'000'000;
        running.boot_time_ns = running.wall_ns = running.mono_ns;
        bench.session.on_status(running, bench.local);
      }
    }
    CHECK_EQUAL(std::int64_t{77}, bench.session.status()->boot_id);
    CHECK_TRUE(bench.shot_results().empty());
    for (const std::string& text : bench.session.take_notifications())
      CHECK_TEXT(text.find("started anew") == text.npos, text.c_str());
  }
}

TEST(SessionOfBoots, ABootOfAnotherFolderIsHeardOnceTheOneBeforeIsSilent) {
  for (const auto& [host_id, silence_ms] : {std::pair{0, 2'500}, std::pair{5, 10'000}}) {
    Bench bench(host_id);
    status_t other{};
    other.boot_id = 75;
    status_t answer = *bench.session.status();
    answer.arm_host_id = 5;
    bench.session.on_status(answer, bench.local);
    const HostTime heard = bench.local;
    bench.session.on_status(other, heard + milliseconds{silence_ms});
    CHECK_EQUAL(std::int64_t{77}, bench.session.status()->boot_id);
    bench.session.on_status(other, heard + milliseconds{silence_ms + 1});
    CHECK_EQUAL(std::int64_t{75}, bench.session.status()->boot_id);
  }
}

TEST(SessionOfBoots, AFiringHostBelievesAnyBootUntilOneHasAnsweredIt) {
  Bench bench(5);  // may be the one that is played back
  status_t other{};
  other.boot_id = 75;
  bench.session.on_status(other, bench.local);
  CHECK_EQUAL(std::int64_t{75}, bench.session.status()->boot_id);
  other.arm_host_id = 5;
  bench.session.on_status(other, bench.local);
  status_t first{};
  first.boot_id = 77;
  first.mono_ns = to_ns(bench.end);
  bench.session.on_status(first, bench.local);
  CHECK_EQUAL(std::int64_t{75}, bench.session.status()->boot_id);
}

TEST(SessionOfBoots, AnotherBootIsSaid) {
  Bench bench;
  bench.status(bench.end, 78);
  STRCMP_CONTAINS("started anew", first_notice(bench.session).c_str());
}
