// Which boots count as rigs of the name: virtual heartbeats, and answers to what is asked.
#include <algorithm>

#include "host/session/live_boots.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using host::LiveBoots;

TEST_GROUP(LiveBoots) {
  LiveBoots boots;
  HostTime now{std::chrono::seconds{50}};

  void setup() override { boots.set_rig("bench"); }
  void beat(std::int64_t boot_id, std::int64_t mono_ns, std::vector<std::int64_t> earlier = {},
            std::int64_t events = 1000) {
    strobe_msgs::status_t status{};
    status.boot_id = boot_id;
    status.mono_ns = mono_ns;
    status.last_sequence = events;
    for (const std::int64_t boot : earlier) status.earlier.push_back({boot, 10});
    boots.on_status(status, boot_id == 0xa ? "10.0.0.1" : "10.0.0.2", now);
  }
  void beat(std::int64_t boot_id) { beat(boot_id, to_ns(now)); }
  /// Heartbeats of both for so long; those in `answering` send what is asked for.
  void beat_on(double seconds, std::vector<std::int64_t> beating, std::vector<std::int64_t> answering) {
    for (int turn = 0; turn < static_cast<int>(seconds * 10.0); ++turn) {
      now += milliseconds{100};
      for (const std::int64_t boot : beating)
        if (turn % 5 == 0) beat(boot);
      for (const EventRange& asked : boots.due(now)) {
        ++asked_;
        if (std::ranges::count(answering, asked.boot_id) > 0)
          boots.on_event(asked.boot_id, asked.sequences.first, now + milliseconds{5});
      }
    }
  }
  std::string problem() const { return boots.problem(now); }
  int asked_ = 0;
};

TEST(LiveBoots, OneRigIsArmedAfterTwoHeartbeatsHadTimeToComeFromAnother) {
  beat(0xa);
  STRCMP_CONTAINS("listening for another rig with the name bench", problem().c_str());
  beat_on(1.5, {0xa}, {});
  CHECK_EQUAL("", problem());
  LONGS_EQUAL(0, asked_);
}

TEST(LiveBoots, TwoThatAnswerAreToldByNameBootAndAddressAndNothingIsArmed) {
  beat_on(5.0, {0xa, 0xb}, {0xa, 0xb});
  CHECK_EQUAL(
      "2 rigs have the name bench: boot a at 10.0.0.1, boot b at 10.0.0.2; stop or rename all but one",
      problem());
  CHECK((boots.heard(now) == std::vector<std::int64_t>{0xa, 0xb}));
  const auto told = boots.take_notifications();
  LONGS_EQUAL(1, told.size());
  CHECK_EQUAL(problem(), told[0]);
  LONGS_EQUAL(4, asked_);  // twice each: then it is known, and asked every 5 s
}

TEST(LiveBoots, ASecondOneCountsFromItsFirstHeartbeatUntilItIsKnownWhatItIs) {
  beat_on(2.0, {0xa}, {0xa});
  beat(0xb);
  STRCMP_CONTAINS("2 rigs may have the name bench: boot a at 10.0.0.1, boot b at 10.0.0.2",
                  problem().c_str());
}

TEST(LiveBoots, ALogThatIsPlayedBackStopsTheShotsForThreeSecondsAtMost) {
  beat_on(2.0, {0xa}, {0xa});
  beat_on(3.0, {0xa, 0xb}, {0xa});
  CHECK_EQUAL("", problem());
  const auto told = boots.take_notifications();
  LONGS_EQUAL(1, told.size());
  STRCMP_CONTAINS("boot b at 10.0.0.2 are heard beside others, and it does not answer", told[0].c_str());
  CHECK((boots.heard(now) == std::vector<std::int64_t>{0xa, 0xb}));  // a DISARM goes there, too
  beat_on(600.0, {0xa, 0xb}, {0xa});
  CHECK_EQUAL("", problem());
  CHECK(boots.take_notifications().empty());
}

TEST(LiveBoots, ARigThatHearsOnlyLaterCountsThen) {
  beat_on(10.0, {0xa, 0xb}, {0xa});
  CHECK_EQUAL("", problem());
  beat_on(12.0, {0xa, 0xb}, {0xa, 0xb});
  STRCMP_CONTAINS("2 rigs have the name", problem().c_str());
}

TEST(LiveBoots, OneThatHasFallenSilentIsNoRig) {
  beat_on(5.0, {0xa, 0xb}, {0xa, 0xb});
  beat_on(3.5, {0xa}, {0xa});
  CHECK_EQUAL("", problem());
  CHECK((boots.heard(now) == std::vector<std::int64_t>{0xa}));
}

TEST(LiveBoots, OneStatusThatComesAgainAndAgainIsNoRig) {
  beat_on(2.0, {0xa}, {0xa});
  beat(0xb, 5);
  for (int i = 0; i < 4; ++i) {
    beat_on(0.5, {0xa}, {0xa});
    beat(0xb, 5);
  }
  CHECK_EQUAL("", problem());
}

TEST(LiveBoots, OneThatTheOtherListsAsEarlierIsNoRig) {
  beat_on(2.0, {0xb}, {0xb});
  beat(0xa, to_ns(now), {0xb});
  beat(0xb);
  CHECK_EQUAL("", problem());
  CHECK((boots.heard(now) == std::vector<std::int64_t>{0xa}));
}

TEST(LiveBoots, NoTwoAreAskedForTheSameEventAtOnce) {
  beat_on(2.0, {0xa}, {0xa});
  for (int i = 0; i < 200; ++i) {
    now += milliseconds{500};
    beat(0xa, to_ns(now), {}, 2);
    beat(0xb, to_ns(now), {}, 2);
    const auto asked = boots.due(now);
    if (asked.size() == 2) CHECK(asked[0].sequences.first != asked[1].sequences.first);
  }
}

TEST(LiveBoots, OneThatAnswersNoMoreCountsNoMore) {
  beat_on(5.0, {0xa, 0xb}, {0xa, 0xb});
  STRCMP_CONTAINS("2 rigs have the name", problem().c_str());
  beat_on(26.0, {0xa, 0xb}, {0xa});
  CHECK_EQUAL("", problem());
}

TEST(LiveBoots, AnEventThatNobodyAskedForIsNoAnswer) {
  beat_on(2.0, {0xa}, {0xa});
  for (int i = 0; i < 100; ++i) {
    beat_on(0.1, {0xa, 0xb}, {0xa});
    boots.on_event(0xb, 2000 + i, now);
  }
  CHECK_EQUAL("", problem());
}

TEST(LiveBoots, HoldsEightBootsHoweverManyComeAndNeverForgetsTheOneThatGoesOn) {
  for (std::int64_t boot = 100; boot < 1100; ++boot) {
    now += milliseconds{1};
    beat(0xa);
    beat(boot);
  }
  CHECK(boots.knows(0xa));
  CHECK(boots.heard(now).size() <= 8);
}

// Whether a rig that is heard hears: commands of each kind, answered and not.
using namespace strobe;
using host::AnswerWatch;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

TEST_GROUP(AnswerWatch) {
  AnswerWatch watch;
  HostTime now{std::chrono::seconds{50}};
  status_t status{};

  void setup() override {
    status.boot_id = 7;
    status.last_sequence = 100;
    status.journal_ok = 1;
  }
  void send(std::int8_t kind) {
    command_t command{};
    command.kind = kind;
    command.host_id = 5;
    command.boot_id = 7;
    command.resend_boot_id = 7;
    command.resend_first = 20;
    command.resend_last = 30;
    watch.on_sent(command, status, now);
  }
  /// A command every 0.3 s, and heartbeats.
  std::string ask(std::int8_t kind, double seconds) {
    for (int turn = 0; turn < static_cast<int>(seconds * 10.0); ++turn) {
      if (turn % 3 == 0) send(kind);
      if (turn % 5 == 0) watch.on_status(status);
      now += milliseconds{100};
    }
    return watch.problem(now);
  }
  void hear(std::int8_t kind, std::int64_t sequence) {
    event_t event{};
    event.boot_id = 7;
    event.kind = kind;
    event.sequence = sequence;
    watch.on_event(event);
  }
};

TEST(AnswerWatch, WhatIsNotAnsweredForTwoSecondsIsTold) {
  for (const std::int8_t kind : {command_t::ARM, command_t::FIRE, command_t::RESEND, command_t::CLEAR}) {
    watch = {};
    CHECK_EQUAL("", ask(kind, 1.9));
    STRCMP_CONTAINS("heard but does not answer", ask(kind, 0.3).c_str());
    STRCMP_CONTAINS("network interface", watch.problem(now).c_str());
    CHECK(watch.problem(now).find("key") == std::string::npos);
  }
}

TEST(AnswerWatch, AnEventThatACommandCausesIsAnAnswer) {
  for (const std::int8_t kind :
       {event_t::ARMED, event_t::REFUSED, event_t::DISARMED, event_t::SHOT_STARTED}) {
    ask(command_t::ARM, 3.0);
    hear(kind, 101);
    CHECK_EQUAL("", watch.problem(now));
  }
}

TEST(AnswerWatch, WhatMovesByItselfAndWhatIsOlderIsNone) {
  ask(command_t::ARM, 3.0);
  for (const std::int8_t kind : {event_t::KEY, event_t::ESTOP, event_t::SENSOR, event_t::FAULT})
    hear(kind, 101);
  hear(event_t::ARMED, 100);
  CHECK(!watch.problem(now).empty());
}

TEST(AnswerWatch, AnEventThatWasAskedForIsAnAnswer) {
  ask(command_t::RESEND, 3.0);
  hear(event_t::KEY, 31);
  CHECK(!watch.problem(now).empty());
  hear(event_t::KEY, 30);
  CHECK_EQUAL("", watch.problem(now));
}

TEST(AnswerWatch, TheStatusThatAnArmOrADisarmAsksForIsAnAnswer) {
  ask(command_t::ARM, 3.0);
  status.arm_host_id = 5;
  status.arm_token = 9;
  watch.on_status(status);
  CHECK_EQUAL("", watch.problem(now));
  STRCMP_CONTAINS("does not answer", ask(command_t::DISARM, 3.0).c_str());
  status.arm_token = 0;
  watch.on_status(status);
  CHECK_EQUAL("", watch.problem(now));
}

TEST(AnswerWatch, WhatHasNoCertainAnswerIsNoQuestion) {
  CHECK_EQUAL("", ask(command_t::DISARM, 5.0));  // it is disarmed already
  status.journal_ok = 0;
  CHECK_EQUAL("", ask(command_t::RESEND, 5.0));
}

TEST(AnswerWatch, ARigThatIsNotHeardAnyMoreIsAnotherMatter) {
  for (int i = 0; i < 20; ++i) {
    send(command_t::ARM);
    now += milliseconds{300};
  }
  CHECK_EQUAL("", watch.problem(now));
}

TEST(AnswerWatch, AnotherKeyIsNamedWhereTheRigCountsOne) {
  ask(command_t::ARM, 1.0);
  status.rejected_forged = 3;
  STRCMP_CONTAINS("another key", ask(command_t::ARM, 2.0).c_str());
}
