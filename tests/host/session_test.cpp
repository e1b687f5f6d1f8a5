// The session logic on messages in virtual time: waiting, time-outs, duplicates, reordering, joining late.
#include <string>

#include "common/messages/json_conversions.hpp"
#include "common/shot/recent_map.hpp"
#include "host/loop/resumption.hpp"
#include "tests/host/session_bench.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::host_test;

TEST_GROUP(SessionOfMessages){};

TEST(SessionOfMessages, ShotAndFrameMakeOneReadout) {
  Bench bench;
  bench.shot();
  CHECK_TRUE(bench.shot_results().empty());
  LONGS_EQUAL(1, bench.session.waiting_for_photograph());
  bench.frame();
  const host::Shot result = bench.only_result();
  CHECK_FALSE(result.rejected.has_value());
  LONGS_EQUAL(77, result.boot_id);
  LONGS_EQUAL(5, result.host_id);
  CHECK_TRUE(result.readout.value[reduction::Quantity::e].has_value());
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
  const host::Shot result = bench.only_result();
  CHECK_TRUE(result.readout.flags.has(Flag::no_photograph));
  CHECK_FALSE(result.readout.value[reduction::Quantity::e].has_value());
  CHECK_TRUE(result.rejected.has_value());
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
  const host::Shot result = bench.only_result();
  CHECK_TRUE(result.readout.flags.has(Flag::shot_aborted));
  STRCMP_CONTAINS("key off", result.problem.c_str());
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
  const host::Shot result = bench.only_result();
  CHECK_TRUE(result.dry);
  CHECK_FALSE(result.rejected.has_value());
  LONGS_EQUAL(166, *result.train.seen_by_a);
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
  CHECK_FALSE(bench.only_result().readout.flags.has(Flag::events_missing));
}

TEST(SessionOfMessages, NumbersOfAShotWhoseEventsNeverComeAreFlagged) {
  Bench bench(5);
  bench.made.shot.first_sequence = 3;
  bench.made.shot.last_sequence = 5;
  bench.shot();
  bench.frame();
  bench.beat_until(bench.end + 6 * kSecond);
  const host::Shot result = bench.only_result();
  CHECK_TRUE(result.readout.flags.has(Flag::events_missing));
  CHECK_TRUE(result.readout.value[reduction::Quantity::e].has_value());
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

TEST(SessionOfMessages, AShotInWhichTheFirmwareDiedIsReportedOnceAllThatWasWrittenIsHere) {
  CutOff bench(5);
  bench.status(bench.end, 78);
  CHECK_TRUE(bench.shot_results().empty());  // more of it may be in the journal
  bench.tell_of_death(5);
  bench.session.on_time(bench.local);
  CHECK_TRUE(bench.shot_results().empty());
  bench.session.on_event(bench.of_kind(event_t::FLASH, 6, 5, ""), bench.local);
  const host::Shot result = bench.only_result();
  LONGS_EQUAL(77, result.boot_id);
  LONGS_EQUAL(6, result.shot_id);
  LONGS_EQUAL(5, result.host_id);
  CHECK_TRUE(result.readout.flags.has(Flag::events_missing));
  CHECK_TRUE(result.readout.flags.has(Flag::shot_aborted));
  CHECK_TRUE(result.rejected.has_value());
  CHECK_FALSE(result.readout.value[reduction::Quantity::e].has_value());
  bench.made.frame.boot_id = 77;
  bench.made.frame.shot_id = 6;
  bench.frame();
  bench.session.on_time(bench.local + kSecond);
  CHECK_TRUE(bench.shot_results().empty());
}

TEST(SessionOfMessages, ADryShotInWhichTheFirmwareDiedIsReportedAsDry) {
  CutOff bench(5, "dry");
  bench.last_written = 4;
  bench.tell_of_death(4);
  bench.session.on_time(bench.local);
  CHECK_TRUE(bench.only_result().dry);
}

TEST(SessionOfMessages, ASummaryThatNeverWasWrittenIsGivenUp) {
  CutOff bench(5);
  bench.session.on_event(ended(6, 5), bench.local);
  bench.tell_of_death(5);
  for (int beat = 0; beat < 40; ++beat) {
    bench.local += kSecond / 2;
    bench.status(bench.end + beat * kSecond / 2, 78);
    bench.session.on_time(bench.local);
  }
  CHECK_TRUE(bench.only_result().readout.flags.has(Flag::events_missing));
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
  const host::Shot result = bench.only_result();
  CHECK_TRUE(result.readout.flags.has(Flag::clock_suspect));
  CHECK_TRUE(result.rejected.has_value());
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

TEST(SessionOfMessages, AtTheEndOfALogWaitingShotsEndWithoutAPhotograph) {
  Bench bench;
  bench.shot();
  bench.session.on_end();
  CHECK_TRUE(bench.shot_results().at(0).readout.flags.has(Flag::no_photograph));
}

using strobe::host::GapRecovery;

TEST_GROUP(GapRecoveryOfAHost) {
  Session session{{}, 5};
  HostTime start{100 * kSecond};
  GapRecovery recovery{start};

  void status(std::int64_t last_sequence, HostTime now) {
    strobe_msgs::status_t message{};
    message.boot_id = 7;
    message.last_sequence = last_sequence;
    session.on_status(message, now);
  }
  void event(std::int64_t sequence, HostTime now) {
    strobe_msgs::event_t message{};
    message.boot_id = 7;
    message.sequence = sequence;
    session.on_event(message, now);
  }
  bool finished(double after_s) { return recovery.finished(session, start + from_seconds(after_s)); }
};

TEST(GapRecoveryOfAHost, WaitsForAStatusThatWasSentAfterItsStart) {
  event(1, start - kSecond);
  status(1, start - kSecond);
  CHECK_FALSE(finished(0.3));
  status(1, start + kSecond / 2);
  CHECK_TRUE(finished(0.6));
}

TEST(GapRecoveryOfAHost, EndsAtOnceWhenTheFirmwareIsSilentAndNothingIsMissing) {
  event(1, start - kSecond);
  CHECK_TRUE(finished(0.0));  // and never was heard: nobody can be asked
  status(1, start - 3 * kSecond);
  CHECK_TRUE(finished(0.0));
}

TEST(GapRecoveryOfAHost, OutlastsANetworkThatIsCutForTenSeconds) {
  status(2, start - kSecond);
  event(1, start - kSecond);
  CHECK_FALSE(finished(0.0));
  CHECK_FALSE(finished(11.0));
  event(2, start + 12 * kSecond);
  status(2, start + 12 * kSecond);
  CHECK_TRUE(finished(12.1));
}

TEST(GapRecoveryOfAHost, GivesUpWhenNothingNewComesAndAfterAMinuteWhateverComes) {
  status(1000, start);
  CHECK_FALSE(finished(0.0));
  CHECK_TRUE(finished(15.1));
  GapRecovery slow(start);
  bool ended = false;
  for (int second = 0; second < 60; ++second) {
    event(second + 1, start + second * kSecond);
    ended = ended || slow.finished(session, start + second * kSecond);
  }
  CHECK_FALSE(ended);
  CHECK_TRUE(slow.finished(session, start + 61 * kSecond));
}

using strobe::RecentMap;

TEST_GROUP(RecentMap) { RecentMap<int, std::string> map{3}; };

TEST(RecentMap, ForgetsWhatWasEnteredFirstNotTheSmallestKey) {
  for (const int key : {9, 5, 7, 1}) map.put(key, std::to_string(key));
  CHECK(map.find(9) == nullptr);
  for (const int key : {5, 7, 1}) STRCMP_EQUAL(std::to_string(key).c_str(), map.find(key)->c_str());
}

TEST(RecentMap, KeepsTheAgeOfWhatIsReplaced) {
  for (const int key : {1, 2, 3}) map.put(key, "old");
  map.put(1, "new");
  STRCMP_EQUAL("new", map.find(1)->c_str());
  map.put(4, "new");
  CHECK(map.find(1) == nullptr);
  LONGS_EQUAL(3, map.all().size());
}

TEST(RecentMap, HasRoomAgainForWhatWasTaken) {
  for (const int key : {1, 2, 3}) map.put(key, "");
  CHECK_TRUE(map.take(2).has_value());
  CHECK_FALSE(map.take(2).has_value());
  map.put(4, "");
  for (const int key : {1, 3, 4}) CHECK(map.find(key) != nullptr);
}
