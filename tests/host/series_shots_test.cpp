// The shots of a series: which are fired, fired again, counted and waited for.
#include "tests/host/scripted_series.hpp"

namespace {

using namespace strobe;
using namespace host_test;

}  // namespace

TEST_GROUP(ShotsOfASeries){};

TEST(ShotsOfASeries, FiresAsManyAsWereAskedForAndNoMore) { Play(series(3)).succeeds(3); }

TEST(ShotsOfASeries, ArmsAndFiresNothingAsLongAsAnotherRigHasTheName) {
  for (const std::int8_t state : {status_t::IDLE, status_t::ARMED}) {
    Play play(series(2));
    while (play.firmware.status.state != state) play.turn();
    play.series.on_second_rig("2 rigs have the name");
    play.run(100);
    LONGS_EQUAL(0, play.firmware.fired);
    LONGS_EQUAL(state, play.firmware.status.state);
    CHECK_EQUAL("2 rigs have the name", play.series.blocking_reason());
    play.series.on_second_rig("");
    play.succeeds(2);
  }
}

TEST(ShotsOfASeries, BeginsOnNoFirmwareThatIsHeardOnlyLongAfterTheCommand) {
  for (const auto& [turns, begins] : {std::pair{490, true}, std::pair{510, false}}) {  // of 20 ms
    Play play(series(1));
    play.heard = false;
    play.run(turns);
    play.heard = true;
    play.run(1000);
    CHECK_EQUAL(begins, play.series.succeeded());
  }
}

TEST(ShotsOfASeries, SaysThatTheRigDoesNotAnswerAndGivesUp) {
  Play play(series(1));
  play.firmware.deaf = true;
  play.series.on_unanswered("heard but does not answer");
  play.run(100);
  CHECK_EQUAL("heard but does not answer", play.series.blocking_reason());
  play.run(2000);
  play.ends("heard but does not answer (waited 60 s)");
}

TEST(ShotsOfASeries, ARejectedShotIsFiredAgainWithinTheRetries) {
  Play play(series(2, 2));
  play.verdicts = {"the shot was aborted", "", "the photograph did not come in time", ""};
  play.succeeds(4);
  LONGS_EQUAL(2, play.series.refired());
  STRCMP_CONTAINS("shot 4 does not count (the shot was aborted): firing again, 1 of 2 times",
                  play.notifications.at(0).c_str());
}

TEST(ShotsOfASeries, TheFirmwaresReasonForAnAbortIsToldWithTheRejection) {
  Play play(series(1));
  play.verdicts = {"the shot was aborted"};
  play.problem = "the trigger was on for 130000 us";
  play.run(1000);
  CHECK_EQUAL(
      "shot 4 does not count (the shot was aborted: the trigger was on for 130000 us), and none may be fired "
      "again",
      play.series.blocking_reason());
}

TEST(ShotsOfASeries, WaitsForAPhotographThatDidNotComeBeforeItFiresAgain) {
  Play play(series(1, 1));
  play.photograph_missing = true;
  play.verdicts = {"the photograph did not come in time", ""};
  while (play.answered < 1) play.run(10);
  const HostTime given_up = play.now;
  // Its 5 s over again, less the turn in which they end.
  while (play.now < given_up + milliseconds{4960}) play.turn();
  LONGS_EQUAL(1, play.firmware.fired);
  STRCMP_CONTAINS("waiting, as a photograph may still come", play.series.activity().c_str());
  CHECK_EQUAL("", play.series.blocking_reason());
  play.run(100);
  LONGS_EQUAL(2, play.firmware.fired);
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotsOfASeries, DryShotsAreFiredDryAndCount) {
  ShotSeriesSettings settings = series(2);
  settings.plan.dry = true;
  Play play(settings);
  bool armed = false;
  for (int i = 0; i < 1000 && !play.series.finished(); ++i) {
    play.now += milliseconds{20};
    play.series.step(play.firmware.status, play.now);
    for (const command_t& command : play.series.take_commands()) {
      if (command.kind == command_t::FIRE) CHECK_TRUE(command.plan.dry);
      armed = armed || command.kind == command_t::ARM;
      play.firmware.dispatch(command, play.series);
    }
    if (i % 10 == 8 && play.firmware.fired > play.answered)
      STRCMP_CONTAINS(": flashing", play.series.activity().c_str());
    if (i % 10 == 9) play.answer();
  }
  CHECK_TRUE(armed);
  play.succeeds(2);
}

TEST(ShotsOfASeries, WithoutRetriesLeftItGivesUp) {
  Play play(series(2, 1));
  play.verdicts = {"x", "x", ""};
  play.ends("", 2);
}

TEST(ShotsOfASeries, LostCommandsAreSentAgainAndNoShotIsFiredTwice) {
  Play play(series(1));
  play.firmware.deaf = true;
  play.run(60);
  LONGS_EQUAL(0, play.firmware.fired);
  play.firmware.deaf = false;
  play.succeeds();
}

TEST(ShotsOfASeries, SaysWhatIsMissing) {
  Play play(series(1));
  play.heard = false;
  play.turn();
  STRCMP_CONTAINS("no firmware heard", play.series.blocking_reason().c_str());
  play.heard = true;
  play.firmware.status.journal_ok = false;
  play.turn();
  CHECK_EQUAL("the firmware's journal cannot be written", play.series.blocking_reason());
  play.firmware.status.message = "the journal cannot be written: disk full";
  play.turn();
  CHECK_EQUAL("the journal cannot be written: disk full", play.series.blocking_reason());
  play.firmware.status.message.clear();
  play.firmware.status.journal_ok = true;
  play.succeeds();
}

TEST(ShotsOfASeries, DoesNotTakeTheRigFromAnotherHostAndSaysWho) {
  for (const std::string who : {"", "eve@lab2"}) {
    Play play(series(1));
    play.armed_by_another();
    if (!who.empty()) play.series.on_arming_of(who, false);
    play.run(100);
    LONGS_EQUAL(0, play.firmware.fired);
    CHECK_EQUAL("another host " + (who.empty() ? "" : "(" + who + ") ") + "has armed the rig",
                play.series.blocking_reason());
  }
}

TEST(ShotsOfASeries, AnEarlierRunOfOnesOwnIsNoOtherHost) {
  for (const auto& [name, own] : {std::pair{"", true}, std::pair{"anna@desk", false}}) {
    Play play(series(1));
    status_t& status = play.armed_by_another();
    status.mono_ns = 1'000'000'000;
    status.arm_expires_ns = 12'400'000'000;
    play.series.on_arming_of(name, own);
    for (int i = 0; i < 2; ++i) {
      play.turn();
      // The same words as long as it lasts: a new one would be told anew.
      CHECK_EQUAL("an earlier run of yours still holds the arming for 12 s", play.series.blocking_reason());
      status.mono_ns += 5'000'000'000;
    }
    status.state = status_t::IDLE;
    status.arm_host_id = status.arm_token = 0;
    play.succeeds();
  }
}

TEST(ShotsOfASeries, ArmsUnderItsName) {
  CommandFactory factory(kHost, "anna@desk");
  const command_t arm = factory.arm(kBoot);
  LONGS_EQUAL(1, arm.note_count);
  CHECK_EQUAL("host_name", arm.notes[0].key);
  CHECK_EQUAL("anna@desk", arm.notes[0].value);
  LONGS_EQUAL(0, CommandFactory(kHost).arm(kBoot).note_count);
}

TEST(ShotsOfASeries, FiresWhatTheSessionLacks) {
  ShotSeriesSettings settings = series(5);
  settings.counted = 3;
  settings.whole_session = true;
  Play play(settings);
  Shot former;
  former.host_id = 999;
  play.series.on_former_result(former);
  former.rejected = "the shot was aborted";
  play.series.on_former_result(former);
  play.succeeds();
  LONGS_EQUAL(5, play.series.good());
}

TEST(ShotsOfASeries, ASessionThatHasEnoughIsNotArmed) {
  ShotSeriesSettings settings = series(2);
  settings.counted = 1;
  settings.whole_session = true;
  Play play(settings);
  play.series.on_former_result({});
  play.heard = false;
  play.turn();
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotsOfASeries, ShotsOfEarlierRunsAreNoneOfASeriesOfItsOwn) {
  Play play(series(1));
  play.series.on_former_result({});
  LONGS_EQUAL(0, play.series.good());
}

TEST(ShotsOfASeries, AnEndThatWasAskedForComesAfterTheShotUnderWayEvenIfItIsRejected) {
  for (const char* verdict : {"", "the photograph did not come in time"}) {
    Play play(series(3, 5));
    play.verdicts = {verdict};
    play.turn_until_fired();
    CHECK_TRUE(play.series.shot_under_way());
    LONGS_EQUAL(4, play.series.shot_number());
    play.series.end_after_shot("interrupted");
    CHECK_FALSE(play.series.finished());
    play.ends("", 1);
    LONGS_EQUAL(0, play.series.refired());
    LONGS_EQUAL(*verdict == '\0' ? 1 : 0, play.series.good());
    CHECK_EQUAL("interrupted", play.series.blocking_reason());
  }
}

TEST(ShotsOfASeries, GivesUpWhenNothingIsPossibleForTooLong) {
  ShotSeriesSettings settings = series(1);
  settings.blocked_timeout_s = 3.0;
  Play play(settings);
  play.firmware.status.journal_ok = false;
  play.run(149);
  CHECK_FALSE(play.series.finished());
  play.run(10);
  CHECK_TRUE(play.series.finished());
  play.ends("the firmware's journal cannot be written (waited 3 s)");
}

TEST(ShotsOfASeries, APlanThatTheFirmwareRefusesEndsIt) {
  Play play(series(1, 5));
  play.firmware.refuses_fire = "period shorter than the lamps' recharge";
  play.ends("period shorter");
}

TEST(ShotsOfASeries, ARefusalFromBeforeTheCommandIsNone) {
  for (const auto& [boot_id, sequence] : {std::pair{kBoot, 10}, std::pair{kBoot - 1, 1000}}) {
    Play play(series(1));
    play.firmware.status.last_sequence = 10;
    event_t old{};
    old.boot_id = boot_id;
    old.sequence = sequence;
    old.kind = event_t::REFUSED;
    for (int i = 0; i < 200 && play.firmware.fired == 0; ++i) {
      play.turn();
      play.series.on_event(old);
    }
    LONGS_EQUAL(1, play.firmware.fired);
    LONGS_EQUAL(0, play.notifications.size());
    play.succeeds();
  }
}

TEST(ShotsOfASeries, AShotThatSeemedRefusedAndWasNotIsWaitedFor) {
  Play play(series(1));
  play.turn_until_fired();
  event_t another_hosts = play.firmware.event(event_t::REFUSED);
  another_hosts.sequence = 1000;
  play.series.on_event(another_hosts);
  for (int i = 0; i < 100; ++i) play.turn();
  play.succeeds();
}

TEST(ShotsOfASeries, NeitherOtherHostsShotsNorThoseOfEarlierNumbersCount) {
  for (const auto& [host_id, shot_id] : {std::pair{999L, 4}, std::pair{+kHost, 3}}) {
    Play play(series(1));
    for (int i = 0; i < 8; ++i) play.turn();
    Shot result;
    result.boot_id = kBoot;
    result.host_id = host_id;
    result.shot_id = shot_id;
    play.series.on_shot_result(result);
    LONGS_EQUAL(0, play.series.good());
  }
}

TEST(ShotsOfASeries, ALatchedFaultIsClearedOnlyWhenAskedTo) {
  for (const bool asked : {false, true}) {
    ShotSeriesSettings settings = series(1);
    settings.clear_fault = asked;
    Play play(settings);
    play.firmware.status.state = status_t::FAULT;
    play.firmware.status.message = "fault: a line cannot be set";
    play.run(100);
    LONGS_EQUAL(asked ? 1 : 0, play.firmware.cleared);
    LONGS_EQUAL(asked ? 1 : 0, play.firmware.fired);
  }
}

TEST(ShotsOfASeries, ThePlanAndTheNotesGoWithTheShot) {
  CommandFactory factory(kHost);
  ShotPlan plan;
  plan.period = microseconds{2500};
  plan.impact_at = milliseconds{120};
  plan.dry = true;
  const command_t fire = factory.fire(kBoot, 9, plan, {{"spin", "top"}, {"angle_deg", "23"}});
  LONGS_EQUAL(2'500'000, fire.plan.period_ns);
  LONGS_EQUAL(120'000'000, fire.plan.impact_at_ns);
  CHECK_TRUE(fire.plan.dry);
  LONGS_EQUAL(2, fire.note_count);
  CHECK_EQUAL("angle_deg", fire.notes[0].key);
  LONGS_EQUAL(1, fire.command_id);
  LONGS_EQUAL(2, factory.arm(kBoot).command_id);
}
