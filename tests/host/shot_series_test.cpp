// Firing a series against a scripted firmware in virtual time.
#include "host/session/shot_series.hpp"

#include <deque>
#include <string>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace host;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr std::int64_t kHost = 0x1234;
constexpr std::int64_t kBoot = 77;

/// Dispatches as the firmware's interlock does, and counts what it did.
struct Firmware {
  status_t status{};
  int fired = 0, armed = 0, reset = 0, cleared = 0;
  bool deaf = false;                        // commands are lost
  std::string refuses_fire, refuses_reset;  // why

  Firmware() {
    status.boot_id = kBoot;
    status.key_active = true;
    status.journal_ok = true;
    status.last_shot_id = 3;
  }
  void dispatch(const command_t& command, ShotSeries& series) {
    if (deaf || command.boot_id != status.boot_id) return;
    if (command.kind == command_t::RESET) {
      ++reset;
      if (status.state == status_t::STOPPED && refuses_reset.empty()) status.state = status_t::IDLE;
      if (!refuses_reset.empty()) refuse("RESET: " + refuses_reset, series);
    } else if (command.kind == command_t::ARM && status.state == status_t::IDLE) {
      ++armed;
      status.state = status_t::ARMED;
      status.arm_host_id = command.host_id;
      status.arm_token = 900 + command.command_id;
    } else if (command.kind == command_t::FIRE && command.arm_token == status.arm_token &&
               status.arm_token != 0) {
      status.state = status_t::IDLE;
      status.arm_host_id = status.arm_token = 0;
      if (!refuses_fire.empty()) {
        return refuse("FIRE: " + refuses_fire, series);
      }
      ++fired;
      ++status.last_shot_id;
    } else if (command.kind == command_t::CLEAR) {
      ++cleared;
      status.state = status_t::IDLE;
      status.message.clear();
    }
  }
  event_t event(std::int8_t kind, const std::string& detail = "") {
    event_t event{};
    event.boot_id = status.boot_id;
    event.kind = kind;
    event.sequence = ++status.last_sequence;
    event.detail = detail;
    return event;
  }
  void refuse(const std::string& why, ShotSeries& series) { series.on_event(event(event_t::REFUSED, why)); }
};

struct Play {
  CommandFactory factory{kHost, "anna@desk"};
  Firmware firmware;
  ShotSeries series;
  HostTime now;
  int answered = 0;
  std::deque<std::string> verdicts;  // of the shots to come; empty text: good
  std::string problem;               // of the rejected ones
  bool photograph_missing = false;   // of those
  std::vector<std::string> notifications;
  bool heard = true;

  explicit Play(ShotSeriesSettings settings) : series(std::move(settings), factory) {}

  void turn() {
    now += milliseconds{20};
    series.step(heard ? std::optional(firmware.status) : std::nullopt, now);
    for (const command_t& command : series.take_commands()) firmware.dispatch(command, series);
    for (const std::string& text : series.take_notifications()) notifications.push_back(text);
  }
  void answer() {
    if (firmware.fired == answered) return;
    Shot shot_result;
    shot_result.boot_id = firmware.status.boot_id;
    shot_result.host_id = kHost;
    shot_result.shot_id = firmware.status.last_shot_id;
    if (!verdicts.empty()) {
      if (!verdicts.front().empty()) {
        shot_result.rejected = verdicts.front();
        shot_result.problem = problem;
        if (photograph_missing) shot_result.readout.flags.set(reduction::Flag::no_photograph);
      }
      verdicts.pop_front();
    }
    ++answered;
    series.on_shot_result(shot_result);
  }
  void run(int turns) {
    for (int i = 0; i < turns && !series.finished(); ++i) {
      turn();
      if (i % 10 == 9) answer();
    }
  }
};

ShotSeriesSettings series(int shots, int retries = 0) {
  ShotSeriesSettings settings;
  settings.shots = shots;
  settings.retries = retries;
  return settings;
}

}  // namespace

TEST_GROUP(ShotSeriesOfAHost){};

TEST(ShotSeriesOfAHost, FiresAsManyAsWereAskedForAndNoMore) {
  Play play(series(3));
  play.run(1000);
  CHECK_TRUE(play.series.finished());
  CHECK_TRUE(play.series.succeeded());
  LONGS_EQUAL(3, play.firmware.fired);
}

TEST(ShotSeriesOfAHost, ArmsNothingWhileAnotherRigHasTheName) {
  Play play(series(2));
  play.series.on_second_rig("2 rigs have the name");
  play.run(100);
  LONGS_EQUAL(0, play.firmware.fired);
  LONGS_EQUAL(status_t::IDLE, play.firmware.status.state);
  CHECK_EQUAL("2 rigs have the name", play.series.blocking_reason());
  play.series.on_second_rig("");
  play.run(1000);
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotSeriesOfAHost, FiresNothingWithATokenAsLongAsAnotherRigIsHeard) {
  Play play(series(1));
  while (play.firmware.status.state != status_t::ARMED) play.turn();
  play.series.on_second_rig("2 rigs have the name");
  play.run(100);
  LONGS_EQUAL(0, play.firmware.fired);
  CHECK_EQUAL("2 rigs have the name", play.series.blocking_reason());
  play.series.on_second_rig("");
  play.run(1000);
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotSeriesOfAHost, BeginsOnNoFirmwareThatIsHeardOnlyLongAfterTheCommand) {
  for (const auto& [turns, begins] : {std::pair{490, true}, std::pair{510, false}}) {  // of 20 ms
    Play play(series(1));
    play.heard = false;
    play.run(turns);
    play.heard = true;
    play.run(1000);
    CHECK_EQUAL(begins, play.series.succeeded());
  }
}

TEST(ShotSeriesOfAHost, SaysThatTheRigDoesNotAnswerAndGivesUp) {
  Play play(series(1));
  play.firmware.deaf = true;
  play.series.on_unanswered("heard but does not answer");
  play.run(100);
  CHECK_EQUAL("heard but does not answer", play.series.blocking_reason());
  play.run(4000);
  CHECK_TRUE(play.series.finished());
  STRCMP_CONTAINS("heard but does not answer (waited 60 s)", play.series.blocking_reason().c_str());
}

TEST(ShotSeriesOfAHost, ARejectedShotIsFiredAgainWithinTheRetries) {
  Play play(series(2, 2));
  play.verdicts = {"the shot was aborted", "", "the photograph did not come in time", ""};
  play.run(2000);
  CHECK_TRUE(play.series.succeeded());
  LONGS_EQUAL(4, play.firmware.fired);
  LONGS_EQUAL(2, play.series.refired());
  STRCMP_CONTAINS("shot 4 does not count (the shot was aborted): firing again, 1 of 2 times",
                  play.notifications.at(0).c_str());
}

TEST(ShotSeriesOfAHost, TheFirmwaresReasonForAnAbortIsToldWithTheRejection) {
  Play play(series(1));
  play.verdicts = {"the shot was aborted"};
  play.problem = "the trigger was on for 130000 us";
  play.run(1000);
  CHECK_EQUAL(
      "shot 4 does not count (the shot was aborted: the trigger was on for 130000 us), and none may be fired "
      "again",
      play.series.blocking_reason());
}

TEST(ShotSeriesOfAHost, WaitsForAPhotographThatDidNotComeBeforeItFiresAgain) {
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

TEST(ShotSeriesOfAHost, DryShotsAreFiredDryAndCount) {
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
  CHECK_TRUE(play.series.succeeded());
  LONGS_EQUAL(2, play.firmware.fired);
}

TEST(ShotSeriesOfAHost, WithoutRetriesLeftItGivesUp) {
  Play play(series(2, 1));
  play.verdicts = {"x", "x", ""};
  play.run(2000);
  CHECK_TRUE(play.series.finished());
  CHECK_FALSE(play.series.succeeded());
  LONGS_EQUAL(2, play.firmware.fired);
}

TEST(ShotSeriesOfAHost, LostCommandsAreSentAgainAndNoShotIsFiredTwice) {
  Play play(series(1));
  play.firmware.deaf = true;
  play.run(60);
  LONGS_EQUAL(0, play.firmware.fired);
  play.firmware.deaf = false;
  play.run(1000);
  LONGS_EQUAL(1, play.firmware.fired);
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotSeriesOfAHost, SaysWhatIsMissing) {
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
  play.run(1000);
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotSeriesOfAHost, DoesNotTakeTheRigFromAnotherHost) {
  Play play(series(1));
  play.firmware.status.state = status_t::ARMED;
  play.firmware.status.arm_host_id = 999;
  play.firmware.status.arm_token = 5;
  play.run(100);
  LONGS_EQUAL(0, play.firmware.fired);
  CHECK_EQUAL("another host has armed the rig", play.series.blocking_reason());
}

TEST(ShotSeriesOfAHost, SaysWhoElseHasArmedTheRig) {
  Play play(series(1));
  play.firmware.status.state = status_t::ARMED;
  play.firmware.status.arm_host_id = 999;
  play.firmware.status.arm_token = 5;
  play.series.on_arming_of("eve@lab2", false);
  play.turn();
  CHECK_EQUAL("another host (eve@lab2) has armed the rig", play.series.blocking_reason());
}

TEST(ShotSeriesOfAHost, AnEarlierRunOfOnesOwnIsNoOtherHost) {
  for (const auto& [name, own] : {std::pair{"", true}, std::pair{"anna@desk", false}}) {
    Play play(series(1));
    status_t& status = play.firmware.status;
    status.state = status_t::ARMED;
    status.arm_host_id = 999;
    status.arm_token = 5;
    status.mono_ns = 1'000'000'000;
    status.arm_expires_ns = 12'400'000'000;
    play.series.on_arming_of(name, own);
    play.turn();
    CHECK_EQUAL("an earlier run of yours still holds the arming for 12 s", play.series.blocking_reason());
    status.mono_ns += 5'000'000'000;
    play.turn();
    // The same words as long as it lasts: a new one would be told anew.
    CHECK_EQUAL("an earlier run of yours still holds the arming for 12 s", play.series.blocking_reason());
    status.state = status_t::IDLE;
    status.arm_host_id = status.arm_token = 0;
    play.run(300);
    CHECK_TRUE(play.series.succeeded());
  }
}

TEST(ShotSeriesOfAHost, ArmsUnderItsName) {
  CommandFactory factory(kHost, "anna@desk");
  const command_t arm = factory.arm(kBoot);
  LONGS_EQUAL(1, arm.note_count);
  CHECK_EQUAL("host_name", arm.notes[0].key);
  CHECK_EQUAL("anna@desk", arm.notes[0].value);
  LONGS_EQUAL(0, CommandFactory(kHost).arm(kBoot).note_count);
}

TEST(ShotSeriesOfAHost, OutputsThatMayBeActiveEndIt) {
  Play play(series(3));
  while (play.firmware.fired == 0) play.turn();
  play.series.on_danger("");
  CHECK_FALSE(play.series.finished());
  play.series.on_danger("THE OUTPUTS MAY BE ACTIVE: no such device");
  CHECK_TRUE(play.series.finished());
  CHECK_FALSE(play.series.succeeded());
  STRCMP_CONTAINS("THE OUTPUTS MAY BE ACTIVE", play.series.blocking_reason().c_str());
}

TEST(ShotSeriesOfAHost, FiresWhatTheSessionLacks) {
  ShotSeriesSettings settings = series(5);
  settings.counted = 3;
  settings.whole_session = true;
  Play play(settings);
  Shot former;
  former.host_id = 999;
  play.series.on_former_result(former);
  former.rejected = "the shot was aborted";
  play.series.on_former_result(former);
  play.run(1000);
  CHECK_TRUE(play.series.succeeded());
  LONGS_EQUAL(1, play.firmware.fired);
  LONGS_EQUAL(5, play.series.good());
}

TEST(ShotSeriesOfAHost, ASessionThatHasEnoughIsNotArmed) {
  ShotSeriesSettings settings = series(2);
  settings.counted = 1;
  settings.whole_session = true;
  Play play(settings);
  play.series.on_former_result({});
  play.heard = false;
  play.turn();
  CHECK_TRUE(play.series.finished());
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotSeriesOfAHost, ShotsOfEarlierRunsAreNoneOfASeriesOfItsOwn) {
  Play play(series(1));
  play.series.on_former_result({});
  LONGS_EQUAL(0, play.series.good());
}

TEST(ShotSeriesOfAHost, AnEndThatWasAskedForComesAfterTheShotUnderWayEvenIfItIsRejected) {
  for (const char* verdict : {"", "the photograph did not come in time"}) {
    Play play(series(3, 5));
    play.verdicts = {verdict};
    while (play.firmware.fired == 0) play.turn();
    CHECK_TRUE(play.series.shot_under_way());
    LONGS_EQUAL(4, play.series.shot_number());
    play.series.end_after_shot("interrupted");
    CHECK_FALSE(play.series.finished());
    play.run(1000);
    CHECK_TRUE(play.series.finished());
    LONGS_EQUAL(1, play.firmware.fired);
    LONGS_EQUAL(0, play.series.refired());
    LONGS_EQUAL(*verdict == '\0' ? 1 : 0, play.series.good());
    CHECK_EQUAL("interrupted", play.series.blocking_reason());
  }
}

TEST(ShotSeriesOfAHost, GivesUpWhenNothingIsPossibleForTooLong) {
  ShotSeriesSettings settings = series(1);
  settings.blocked_timeout_s = 3.0;
  Play play(settings);
  play.firmware.status.journal_ok = false;
  play.run(149);
  CHECK_FALSE(play.series.finished());
  play.run(10);
  CHECK_TRUE(play.series.finished());
  STRCMP_CONTAINS("the firmware's journal cannot be written (waited 3 s)",
                  play.series.blocking_reason().c_str());
}

TEST(ShotSeriesOfAHost, APlanThatTheFirmwareRefusesEndsIt) {
  Play play(series(1, 5));
  play.firmware.refuses_fire = "period shorter than the lamps' recharge";
  play.run(2000);
  CHECK_TRUE(play.series.finished());
  CHECK_FALSE(play.series.succeeded());
  STRCMP_CONTAINS("period shorter", play.series.blocking_reason().c_str());
}

TEST(ShotSeriesOfAHost, ARefusalFromBeforeTheCommandIsNone) {
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
    play.run(300);
    CHECK_TRUE(play.series.succeeded());
    LONGS_EQUAL(1, play.firmware.fired);
  }
}

TEST(ShotSeriesOfAHost, AShotThatSeemedRefusedAndWasNotIsWaitedFor) {
  Play play(series(1));
  while (play.firmware.fired == 0) play.turn();
  event_t another_hosts{};
  another_hosts.boot_id = kBoot;
  another_hosts.sequence = 1000;
  another_hosts.kind = event_t::REFUSED;
  play.series.on_event(another_hosts);
  for (int i = 0; i < 100; ++i) play.turn();
  play.run(300);
  CHECK_TRUE(play.series.succeeded());
  LONGS_EQUAL(1, play.firmware.fired);
}

TEST(ShotSeriesOfAHost, OtherHostsShotsDoNotCount) {
  Play play(series(1));
  for (int i = 0; i < 8; ++i) play.turn();
  Shot foreign;
  foreign.boot_id = kBoot;
  foreign.host_id = 999;
  foreign.shot_id = 4;
  play.series.on_shot_result(foreign);
  LONGS_EQUAL(0, play.series.good());
}

TEST(ShotSeriesOfAHost, AShotOfAnEarlierNumberIsNotTakenForTheNewOne) {
  Play play(series(1));
  for (int i = 0; i < 8; ++i) play.turn();
  Shot stale;
  stale.boot_id = kBoot;
  stale.host_id = kHost;
  stale.shot_id = 3;  // was last before this one
  play.series.on_shot_result(stale);
  LONGS_EQUAL(0, play.series.good());
}

TEST(ShotSeriesOfAHost, AFirmwareStartedAnewEndsIt) {
  Play play(series(1, 1));
  for (int i = 0; i < 8; ++i) play.turn();
  LONGS_EQUAL(1, play.firmware.fired);
  play.firmware.status.boot_id = 78;
  play.answered = 1;  // that shot's readout never comes
  play.run(1000);
  CHECK_TRUE(play.series.finished());
  LONGS_EQUAL(1, play.firmware.fired);
  CHECK_EQUAL("the firmware was started anew", play.series.blocking_reason());
}

namespace {

/// What a person, or a failure, does to the rig; and how its end tells of it.
struct Stop {
  void (*come)(status_t&);
  const char* words;
};
const std::vector<Stop> kStops{
    {[](status_t& status) { status.estop_active = true; }, "the e-stop is pressed"},
    {[](status_t& status) { status.key_active = false; }, "the key is off"},
    {[](status_t& status) {
       status.state = status_t::STOPPED;
       status.message = "stopped (disarmed by command): a person must give the command to fire anew";
     },
     "stopped (disarmed by command)"},
    {[](status_t& status) { status.state = status_t::FAULT; }, "the rig has a fault"}};

void all_well(status_t& status) {
  status.state = status_t::IDLE;
  status.estop_active = false;
  status.key_active = true;
  status.message.clear();
}

}  // namespace

TEST(ShotSeriesOfAHost, AStopBetweenTwoShotsEndsItAndWhatReturnsStartsNothing) {
  for (const Stop& stop : kStops) {
    Play play(series(5, 5));
    while (play.series.good() == 0) play.run(1), play.answer();
    const int armed = play.firmware.armed;
    stop.come(play.firmware.status);
    play.turn();
    all_well(play.firmware.status);
    play.run(1000);
    CHECK_TRUE(play.series.finished());
    LONGS_EQUAL(armed, play.firmware.armed);
    STRCMP_CONTAINS(stop.words, play.series.blocking_reason().c_str());
  }
}

TEST(ShotSeriesOfAHost, AStopInAShotEndsItWithThatShotAndIsNoReasonToFireAgain) {
  for (const Stop& stop : kStops) {
    Play play(series(5, 5));
    while (play.firmware.fired == 0) play.turn();
    stop.come(play.firmware.status);
    play.turn();
    CHECK_FALSE(play.series.finished());  // the shot's end is still to be heard
    all_well(play.firmware.status);
    play.verdicts = {"the shot was aborted"};
    play.run(1000);
    CHECK_TRUE(play.series.finished());
    LONGS_EQUAL(1, play.firmware.fired);
    LONGS_EQUAL(0, play.series.refired());
    STRCMP_CONTAINS(stop.words, play.series.blocking_reason().c_str());
  }
}

TEST(ShotSeriesOfAHost, AStopThatOnlyAnEventTellsOfEndsItToo) {
  for (const auto& [kind, detail] : {std::pair{event_t::KEY, ""}, std::pair{event_t::ESTOP, ""},
                                     std::pair{event_t::DISARMED, "disarmed by command of 99 eve@lab2"},
                                     std::pair{event_t::DISARMED, "the machine was suspended"}}) {
    Play play(series(5, 5));
    play.run(1);
    play.series.on_event(play.firmware.event(static_cast<std::int8_t>(kind), detail));
    play.run(1000);
    CHECK_TRUE(play.series.finished());
    LONGS_EQUAL(0, play.firmware.fired);
  }
}

TEST(ShotSeriesOfAHost, BeginsNothingThatASwitchIsInTheWayOf) {
  for (const std::size_t which : {0, 1}) {
    Play play(series(1));
    kStops[which].come(play.firmware.status);
    play.turn();
    CHECK_TRUE(play.series.finished());
    STRCMP_CONTAINS("then give the command again", play.series.blocking_reason().c_str());
    LONGS_EQUAL(0, play.firmware.reset);
  }
}

TEST(ShotSeriesOfAHost, ResetsAStopFromBeforeAsAPersonHasGivenTheCommand) {
  Play play(series(1));
  kStops[2].come(play.firmware.status);
  play.firmware.deaf = true;
  play.run(40);
  play.firmware.deaf = false;  // the first ones were lost
  play.run(20);
  LONGS_EQUAL(1, play.firmware.reset);
  play.firmware.status.message.clear();
  play.run(1000);
  CHECK_TRUE(play.series.succeeded());
}

TEST(ShotSeriesOfAHost, GivesUpWhereTheResetIsRefused) {
  Play play(series(1));
  kStops[2].come(play.firmware.status);
  play.firmware.refuses_reset = "a stop, or a switch's return, came after it was asked for: ask anew";
  play.run(100);
  CHECK_TRUE(play.series.finished());
  STRCMP_CONTAINS("refused: RESET: a stop", play.series.blocking_reason().c_str());
}

TEST(ShotSeriesOfAHost, WantsADisarmWhereItEndsWhileItArms) {
  Play play(series(1));
  play.firmware.deaf = true;
  play.run(20);
  CHECK_FALSE(play.series.take_disarm());
  play.series.end_after_shot("interrupted");
  CHECK_TRUE(play.series.take_disarm());
  CHECK_FALSE(play.series.take_disarm());
}

TEST(ShotSeriesOfAHost, EndsWhenAnotherHostDisarmsWhatItHasArmed) {
  for (const std::int8_t kind : {event_t::DISARMED, event_t::SHOT_ABORTED}) {
    Play play(series(50, 5));
    for (int i = 0; i < 8; ++i) play.turn();
    LONGS_EQUAL(1, play.firmware.fired);
    event_t event{};
    event.boot_id = kBoot;
    event.kind = kind;
    event.detail = "disarmed by command";
    event.sequence = play.firmware.status.last_sequence;  // of before: a log that is played back
    play.series.on_event(event);
    ++event.sequence;
    event.detail = "key off";
    play.series.on_event(event);
    play.verdicts = {"the shot was aborted"};
    play.run(50);
    CHECK(play.firmware.fired > 1);  // neither of these ended it
    while (!play.series.shot_under_way()) play.turn();
    const int fired = play.firmware.fired;
    event.detail = "disarmed by command";
    event.sequence = play.firmware.status.last_sequence + 100;
    play.series.on_event(event);
    play.run(500);
    CHECK_TRUE(play.series.finished());
    CHECK_FALSE(play.series.succeeded());
    CHECK(play.firmware.fired <= fired + 1);
    STRCMP_CONTAINS("another host has disarmed the rig", play.series.blocking_reason().c_str());
  }
}

TEST(ShotSeriesOfAHost, ALatchedFaultIsClearedOnlyWhenAskedTo) {
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

TEST(ShotSeriesOfAHost, ThePlanAndTheNotesGoWithTheShot) {
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
