// The session logic on messages in virtual time: waiting, time-outs, duplicates, reordering, joining late.
#include "host/session/session.hpp"

#include <string>

#include "common/messages/json_conversions.hpp"
#include "tests/host/synthetic_shot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::Session;
using host::ShotResult;
using host_test::make_shot;
using host_test::SyntheticShot;
using reduction::Flag;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr Duration kSecond = std::chrono::seconds{1};

host::AssemblySettings settings() {
  host::AssemblySettings s;
  s.machine_lag_s = host_test::kMachineLag_s;
  s.analysis.photograph_timeout_s = 5.0;
  return s;
}

/// Host and firmware clocks differ by an arbitrary offset.
struct Bench {
  Session session;
  SyntheticShot made = make_shot({});
  HostTime local{40 * kSecond};
  MonoTime end = from_ns(made.shot.shutter_close_ns);
  std::int64_t last_written = 5;  ///< of boot 77, as later ones say

  explicit Bench(std::int64_t host_id = 0) : session(settings(), host_id) { status(end - kSecond / 2); }

  MonoTime newest() const { return from_ns(session.status()->mono_ns); }
  void status(MonoTime mono, std::int64_t boot_id = 77) {
    status_t status{};
    status.boot_id = boot_id;
    status.mono_ns = status.boot_time_ns = status.wall_ns = to_ns(mono);
    if (boot_id != 77) status.earlier.push_back({77, last_written});
    status.earlier_count = static_cast<std::int32_t>(status.earlier.size());
    if (session.status()) local += mono - newest();
    session.on_status(status, local);
  }
  /// A heartbeat every half second.
  void beat_until(MonoTime mono) {
    for (MonoTime beat = newest() + kSecond / 2; beat < mono; beat += kSecond / 2) status(beat);
    status(mono);
  }
  void shot() { session.on_shot(made.shot, local); }
  void frame() { session.on_frame(made.frame, local); }
  std::vector<ShotResult> shot_results() { return session.take_shot_results(); }
};

event_t ended(std::int32_t shot_id, std::int64_t sequence) {
  event_t event{};
  event.boot_id = 77;
  event.shot_id = shot_id;
  event.sequence = sequence;
  event.kind = event_t::SHOT_ENDED;
  return event;
}

std::string first_notice(Session& session) {
  const auto notifications = session.take_notifications();
  return notifications.empty() ? "" : notifications.front();
}

}  // namespace

TEST_GROUP(SessionOfMessages){};

TEST(SessionOfMessages, ShotAndFrameMakeOneReadout) {
  Bench bench;
  bench.shot();
  CHECK_TRUE(bench.shot_results().empty());
  LONGS_EQUAL(1, bench.session.waiting_for_photograph());
  bench.frame();
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_FALSE(shot_results[0].rejected.has_value());
  LONGS_EQUAL(77, shot_results[0].boot_id);
  LONGS_EQUAL(5, shot_results[0].host_id);
  CHECK_TRUE(shot_results[0].readout.value[reduction::Quantity::e].has_value());
}

TEST(SessionOfMessages, TheFrameMayComeBeforeTheShot) {
  Bench usual, reversed;
  usual.shot();
  usual.frame();
  reversed.frame();
  CHECK_TRUE(reversed.shot_results().empty());
  reversed.shot();
  CHECK_EQUAL(messages::readout_to_json(usual.shot_results().at(0).readout),
              messages::readout_to_json(reversed.shot_results().at(0).readout));
}

TEST(SessionOfMessages, DuplicatesChangeNothing) {
  Bench bench;
  bench.shot();
  bench.shot();
  bench.frame();
  bench.frame();
  bench.shot();
  bench.frame();
  LONGS_EQUAL(1, bench.shot_results().size());
  CHECK_TRUE(bench.session.take_notifications().empty());
}

TEST(SessionOfMessages, ASecondFrameThatDiffersIsSaidAndDoesNotChangeTheReadout) {
  Bench bench;
  bench.shot();
  bench.frame();
  bench.made.frame.images[0].centre_x_px += 5;
  bench.frame();
  LONGS_EQUAL(1, bench.shot_results().size());
  STRCMP_CONTAINS("second, different frame of shot 1", first_notice(bench.session).c_str());
}

TEST(SessionOfMessages, AFrameThatDoesNotKnowItsFirmwareGoesToTheNewestShotOfItsNumber) {
  Bench bench;
  bench.shot();
  SyntheticShot other = bench.made;
  other.shot.boot_id = 78;
  other.shot.start_ns += 1'000'000'000;
  bench.session.on_shot(other.shot, bench.local);
  bench.made.frame.boot_id = 0;
  bench.frame();
  LONGS_EQUAL(77, bench.shot_results().at(0).boot_id);  // which is running
}

TEST(SessionOfMessages, AFrameThatDoesNotKnowItsFirmwareIsNotGivenByTheClocksOfTwoBoots) {
  Bench bench;
  bench.shot();
  bench.status(MonoTime{3 * kSecond}, 76);  // its clock began at 0
  SyntheticShot other = bench.made;
  other.shot.boot_id = 76;
  other.shot.start_ns = to_ns(bench.newest());
  bench.session.on_shot(other.shot, bench.local);
  bench.made.frame.boot_id = 0;
  bench.frame();
  LONGS_EQUAL(76, bench.shot_results().at(0).boot_id);
}

TEST(SessionOfMessages, TheWaitForThePhotographEndsByTheFirmwaresClock) {
  Bench bench;
  bench.shot();
  bench.local += 100 * kSecond;  // whatever the host's own clock says, while the firmware is heard
  bench.beat_until(bench.end + 5 * kSecond);
  bench.session.on_time(bench.local);
  CHECK_TRUE(bench.shot_results().empty());
  bench.status(bench.end + 5 * kSecond + Duration{1});
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::no_photograph));
  CHECK_FALSE(shot_results[0].readout.value[reduction::Quantity::e].has_value());
  CHECK_TRUE(shot_results[0].rejected.has_value());
}

TEST(SessionOfMessages, ASilentFirmwareDoesNotMakeItWaitForEver) {
  Bench bench;
  bench.shot();
  bench.session.on_time(bench.local + 14 * kSecond);
  CHECK_TRUE(bench.shot_results().empty());  // 5 s, and the network may have been cut for ten
  bench.session.on_time(bench.local + 16 * kSecond);
  LONGS_EQUAL(1, bench.shot_results().size());
}

TEST(SessionOfMessages, ALatePhotographIsSaidAndTheReadoutStands) {
  Bench bench;
  bench.shot();
  bench.beat_until(bench.end + 6 * kSecond);
  LONGS_EQUAL(1, bench.shot_results().size());
  bench.frame();
  CHECK_TRUE(bench.shot_results().empty());
  STRCMP_CONTAINS("photograph of shot 1 came too late", first_notice(bench.session).c_str());
}

TEST(SessionOfMessages, AShotAbortedBeforeTheTriggerIsDoneAtOnce) {
  Bench bench;
  bench.made.shot.aborted = true;
  bench.made.shot.abort_reason = "key off";
  bench.made.shot.trigger_ns = strobe_msgs::shot_t::NO_TIME;
  bench.shot();
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::shot_aborted));
  STRCMP_CONTAINS("key off", shot_results[0].problem.c_str());
  bench.frame();  // of an empty plate; nothing to say of it
  CHECK_TRUE(bench.session.take_notifications().empty());
}

TEST(SessionOfMessages, AShotAbortedAfterTheBallWaitsForItsPhotograph) {
  Bench bench;
  bench.made.shot.aborted = true;
  bench.shot();
  CHECK_TRUE(bench.shot_results().empty());
  bench.frame();
  const auto shot_results = bench.shot_results();
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::shot_aborted));
  CHECK_TRUE(shot_results[0].readout.value[reduction::Quantity::e].has_value());
  CHECK_TRUE(shot_results[0].rejected.has_value());
}

TEST(SessionOfMessages, ADryShotIsDoneWithoutAPhotograph) {
  Bench bench;
  bench.made.shot.plan.dry = true;
  bench.shot();
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].dry);
  CHECK_FALSE(shot_results[0].rejected.has_value());
  LONGS_EQUAL(166, *shot_results[0].train.seen_by_a);
}

TEST(SessionOfMessages, AShotThatWasOverLongAgoIsNotWaitedForByAPassiveHost) {
  Bench bench;
  bench.status(bench.end + 60 * kSecond);
  bench.shot();
  LONGS_EQUAL(0, bench.session.waiting_for_photograph());
  bench.beat_until(bench.end + 70 * kSecond);
  CHECK_TRUE(bench.shot_results().empty());
  STRCMP_CONTAINS("before this session was joined", first_notice(bench.session).c_str());
}

TEST(SessionOfMessages, AShotThatWasOverLongAgoIsReadOutIfItsPhotographComesAfterAll) {
  Bench bench;
  bench.status(bench.end + 60 * kSecond);
  bench.shot();
  bench.frame();
  LONGS_EQUAL(1, bench.shot_results().size());
}

TEST(SessionOfMessages, TimeInWhichTheFirmwareWasNotHeardDoesNotCountAsWaiting) {
  Bench bench(5);
  bench.shot();
  bench.status(bench.end + 11 * kSecond);  // after ten seconds of a cut network
  CHECK_TRUE(bench.shot_results().empty());
  bench.frame();
  CHECK_FALSE(bench.shot_results().at(0).rejected.has_value());
}

TEST(SessionOfMessages, NoNumberIsGivenBeforeAllEventsOfItsShotAreHere) {
  Bench bench(5);
  bench.made.shot.first_sequence = 3;
  bench.made.shot.last_sequence = 6;
  bench.session.on_event(ended(0, 3), bench.local);
  bench.session.on_event(ended(0, 6), bench.local);
  bench.shot();
  bench.frame();
  CHECK_TRUE(bench.shot_results().empty());
  bench.session.on_event(ended(0, 4), bench.local);
  CHECK_TRUE(bench.shot_results().empty());
  bench.session.on_event(ended(0, 5), bench.local);
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_FALSE(shot_results[0].readout.flags.has(Flag::events_missing));
}

TEST(SessionOfMessages, NumbersOfAShotWhoseEventsNeverComeAreFlagged) {
  Bench bench(5);
  bench.made.shot.first_sequence = 3;
  bench.made.shot.last_sequence = 5;
  bench.shot();
  bench.frame();
  bench.beat_until(bench.end + 6 * kSecond);
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::events_missing));
  CHECK_TRUE(shot_results[0].readout.value[reduction::Quantity::e].has_value());
}

TEST(SessionOfMessages, APhotographThatIsLateIsAskedForByItsShot) {
  Bench bench(5);
  bench.made.shot.first_sequence = bench.made.shot.last_sequence = 1;
  bench.session.on_event(ended(0, 1), bench.local);
  bench.shot();
  bench.session.on_time(bench.local + kSecond / 2);
  CHECK_TRUE(bench.session.ledger().due(bench.local + kSecond / 2).empty());
  bench.session.on_time(bench.local + 2 * kSecond);
  const auto asks = bench.session.ledger().due(bench.local + 2 * kSecond);
  LONGS_EQUAL(1, asks.size());
  LONGS_EQUAL(1, asks[0].sequences.first);
}

/// Events 1 to 4 of boot 77: armed by host 5, shot 6 started, two flashes; then the firmware dies.
struct CutOff : Bench {
  explicit CutOff(std::int64_t host_id, const std::string& kind_of_shot = "") : Bench(host_id) {
    session.on_event(of_kind(event_t::ARMED, 0, 1, "5"), local);
    session.on_event(of_kind(event_t::SHOT_STARTED, 6, 2, kind_of_shot), local);
    session.on_event(of_kind(event_t::FLASH, 6, 3, ""), local);
    session.on_event(of_kind(event_t::FLASH, 6, 4, ""), local);
  }
  static event_t of_kind(std::int8_t kind, std::int32_t shot_id, std::int64_t sequence,
                         const std::string& detail) {
    event_t event = ended(shot_id, sequence);
    event.kind = kind;
    event.detail = detail;
    return event;
  }
};

TEST(SessionOfMessages, AShotInWhichTheFirmwareDiedIsReportedOnceAllThatWasWrittenIsHere) {
  CutOff bench(5);
  bench.status(bench.end, 78);
  CHECK_TRUE(bench.shot_results().empty());  // more of it may be in the journal
  const host::EndedBoot dead{77, 5};
  bench.session.ledger().earlier({&dead, 1}, bench.local);
  bench.session.on_time(bench.local);
  CHECK_TRUE(bench.shot_results().empty());
  bench.session.on_event(bench.of_kind(event_t::FLASH, 6, 5, ""), bench.local);
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  LONGS_EQUAL(77, shot_results[0].boot_id);
  LONGS_EQUAL(6, shot_results[0].shot_id);
  LONGS_EQUAL(5, shot_results[0].host_id);
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::events_missing));
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::shot_aborted));
  CHECK_TRUE(shot_results[0].rejected.has_value());
  CHECK_FALSE(shot_results[0].readout.value[reduction::Quantity::e].has_value());
  bench.made.frame.boot_id = 77;
  bench.made.frame.shot_id = 6;
  bench.frame();
  bench.session.on_time(bench.local + kSecond);
  CHECK_TRUE(bench.shot_results().empty());
}

TEST(SessionOfMessages, ADryShotInWhichTheFirmwareDiedIsReportedAsDry) {
  CutOff bench(5, "dry");
  bench.last_written = 4;
  bench.status(bench.end, 78);
  const host::EndedBoot dead{77, 4};
  bench.session.ledger().earlier({&dead, 1}, bench.local);
  bench.session.on_time(bench.local);
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].dry);
}

TEST(SessionOfMessages, ASummaryThatNeverWasWrittenIsGivenUp) {
  CutOff bench(5);
  bench.session.on_event(ended(6, 5), bench.local);
  const host::EndedBoot dead{77, 5};
  bench.status(bench.end, 78);
  bench.session.ledger().earlier({&dead, 1}, bench.local);
  for (int beat = 0; beat < 40; ++beat) {
    bench.local += kSecond / 2;
    bench.status(bench.end + beat * kSecond / 2, 78);
    bench.session.on_time(bench.local);
  }
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::events_missing));
  CHECK_TRUE(bench.session.ledger().complete());
}

TEST(SessionOfMessages, TheHostThatFiredItGetsAReadoutHoweverLateTheShotIsHeardOf) {
  Bench bench(5);
  bench.status(bench.end + 60 * kSecond);
  bench.shot();
  bench.beat_until(bench.end + 64 * kSecond);
  CHECK_TRUE(bench.shot_results().empty());  // whoever sends the shot again may send its photograph again
  bench.beat_until(bench.end + 66 * kSecond);
  LONGS_EQUAL(1, bench.shot_results().size());
}

TEST(SessionOfMessages, TheSummaryOfAShotThatEndedIsAskedForWhenItIsLost) {
  Bench bench(5);
  for (std::int64_t s = 1; s < 9; ++s) {
    event_t event = ended(0, s);
    event.kind = event_t::FLASH;
    bench.session.on_event(event, bench.local);
  }
  bench.session.on_event(ended(1, 9), bench.local);
  bench.session.on_time(bench.local + kSecond / 10);
  CHECK_TRUE(bench.session.ledger().due(bench.local + kSecond / 5).empty());
  bench.session.on_time(bench.local + kSecond);
  const auto asks = bench.session.ledger().due(bench.local + kSecond);
  LONGS_EQUAL(1, asks.size());
  LONGS_EQUAL(9, asks[0].sequences.first);
}

TEST(SessionOfMessages, AShotDuringWhichTheFirmwaresMachineWasSuspendedHasNoTimesToTrust) {
  Bench bench;
  bench.shot();
  status_t woken{};
  woken.boot_id = 77;
  woken.mono_ns = to_ns(bench.end + kSecond / 10);
  woken.boot_time_ns = woken.mono_ns + 30'000'000'000;  // the heartbeat before had both at the same
  bench.session.on_status(woken, bench.local + 30 * kSecond);
  bench.frame();
  const auto shot_results = bench.shot_results();
  LONGS_EQUAL(1, shot_results.size());
  CHECK_TRUE(shot_results[0].readout.flags.has(Flag::clock_suspect));
  CHECK_TRUE(shot_results[0].rejected.has_value());
}

TEST(SessionOfMessages, TheWaitForThePhotographEndsAlsoAfterTheFirmwaresMachineWasStartedAnew) {
  Bench bench(5);
  bench.shot();
  const HostTime before = bench.local;
  bench.status(MonoTime{30 * kSecond}, 78);  // its clock began at 0
  bench.local = before + 60 * kSecond;
  CHECK_TRUE(bench.shot_results().empty());
  SyntheticShot made = bench.made;
  made.shot.boot_id = 78;
  made.shot.shutter_close_ns = to_ns(bench.newest());
  made.shot.flashes.clear();
  bench.session.on_shot(made.shot, bench.local);
  LONGS_EQUAL(2, bench.session.waiting_for_photograph());
  for (int beat = 1; beat <= 12; ++beat) bench.status(MonoTime{30 * kSecond + beat * kSecond / 2}, 78);
  LONGS_EQUAL(2, bench.shot_results().size());
}

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

TEST(SessionOfMessages, ShotsOfBothBootsAreWaitedForByTheirOwnClocks) {
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

TEST(SessionOfMessages, ShotsOfANewBootAreReadOutByAPassiveHostWhateverTheClockOfTheOneBefore) {
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

TEST(SessionOfMessages, WhatAnEarlierBootSentAndComesLateChangesNothing) {
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

TEST(SessionOfMessages, AStatusThatWasOvertakenChangesNothing) {
  Bench bench;
  bench.status(bench.end + kSecond);
  bench.status(bench.end);
  CHECK(bench.newest() == bench.end + kSecond);
}

TEST(SessionOfMessages, AShotOfABootThatEndedBeforeTheSessionWasJoinedIsNotWaitedFor) {
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

TEST(SessionOfMessages, AnEarlierBootThatIsPlayedBackEndsNoShot) {
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

TEST(SessionOfMessages, ABootOfAnotherFolderIsHeardOnceTheOneBeforeIsSilent) {
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

TEST(SessionOfMessages, AFiringHostBelievesAnyBootUntilOneHasAnsweredIt) {
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

TEST(SessionOfMessages, AnotherBootIsSaid) {
  Bench bench;
  bench.status(bench.end, 78);
  STRCMP_CONTAINS("started anew", first_notice(bench.session).c_str());
}

TEST(SessionOfMessages, AtTheEndOfALogWaitingShotsEndWithoutAPhotograph) {
  Bench bench;
  bench.shot();
  bench.session.on_end();
  CHECK_TRUE(bench.shot_results().at(0).readout.flags.has(Flag::no_photograph));
}
