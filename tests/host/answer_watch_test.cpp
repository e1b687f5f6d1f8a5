// Whether a rig that is heard hears: commands of each kind, answered and not.
#include "host/session/answer_watch.hpp"

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

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
