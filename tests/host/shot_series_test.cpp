// What ends a series: stops, dangers, a firmware that is started anew.
#include "tests/host/scripted_series.hpp"

namespace {

using namespace strobe;
using namespace host_test;

}  // namespace

TEST_GROUP(ShotSeriesOfAHost){};

TEST(ShotSeriesOfAHost, OutputsThatMayBeActiveEndIt) {
  Play play(series(3));
  play.turn_until_fired();
  play.series.on_danger("");
  CHECK_FALSE(play.series.finished());
  play.series.on_danger("THE OUTPUTS MAY BE ACTIVE: no such device");
  CHECK_TRUE(play.series.finished());
  play.ends("THE OUTPUTS MAY BE ACTIVE", 1);
}

TEST(ShotSeriesOfAHost, AFirmwareStartedAnewEndsIt) {
  Play play(series(1, 1));
  play.turn_until_fired();
  play.firmware.status.boot_id = 78;
  play.answered = 1;  // that shot's readout never comes
  play.ends("", 1);
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
    play.ends(stop.words, 1);
    LONGS_EQUAL(armed, play.firmware.armed);
  }
}

TEST(ShotSeriesOfAHost, AStopInAShotEndsItWithThatShotAndIsNoReasonToFireAgain) {
  for (const Stop& stop : kStops) {
    Play play(series(5, 5));
    play.turn_until_fired();
    stop.come(play.firmware.status);
    play.turn();
    CHECK_FALSE(play.series.finished());  // the shot's end is still to be heard
    all_well(play.firmware.status);
    play.verdicts = {"the shot was aborted"};
    play.ends(stop.words, 1);
    LONGS_EQUAL(0, play.series.refired());
  }
}

TEST(ShotSeriesOfAHost, WaitsWhileTheCameraIsAwayAndGoesOnByItself) {
  Play play(series(3));
  play.turn_until_fired();
  play.answer();
  play.series.on_camera("the camera is gone: it does not answer", true);
  play.run(200);
  LONGS_EQUAL(1, play.firmware.fired);
  STRCMP_EQUAL("the camera is gone: it does not answer", play.series.blocking_reason().c_str());
  play.series.on_camera("", true);
  play.succeeds(3);
}

TEST(ShotSeriesOfAHost, FiresNothingWithATokenThatItGotAsTheCameraWentAway) {
  Play play(series(1));
  while (play.firmware.armed == 0) play.turn();
  play.series.on_camera("the camera is gone: it does not answer", true);
  play.run(200);
  LONGS_EQUAL(0, play.firmware.fired);
  play.series.on_camera("", true);
  play.succeeds(1);
}

TEST(ShotSeriesOfAHost, AStopThatOnlyAnEventTellsOfEndsItToo) {
  for (const auto& [kind, detail] : {std::pair{event_t::KEY, ""}, std::pair{event_t::ESTOP, ""},
                                     std::pair{event_t::DISARMED, "disarmed by command of 99 eve@lab2"},
                                     std::pair{event_t::DISARMED, "the rig's computer was suspended"}}) {
    Play play(series(5, 5));
    play.run(1);
    play.series.on_event(play.firmware.event(static_cast<std::int8_t>(kind), detail));
    play.ends("");
  }
}

TEST(ShotSeriesOfAHost, BeginsNothingThatASwitchIsInTheWayOf) {
  for (const std::size_t which : {0, 1}) {
    Play play(series(1));
    kStops[which].come(play.firmware.status);
    play.turn();
    CHECK_TRUE(play.series.finished());
    play.ends("then give the command again");
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
  play.succeeds();
}

TEST(ShotSeriesOfAHost, GivesUpWhereTheResetIsRefused) {
  Play play(series(1));
  kStops[2].come(play.firmware.status);
  play.firmware.refuses_reset =
      "the rig was stopped, or key or e-stop moved, after this command was given: give it again";
  play.ends("refused: RESET: the rig was stopped");
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
    play.turn_until_fired();
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
