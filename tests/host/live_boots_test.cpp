// Which boots count as rigs of the name: virtual heartbeats, and answers to what is asked.
#include "host/session/live_boots.hpp"

#include <algorithm>

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
  STRCMP_CONTAINS("listening whether another rig has the name bench", problem().c_str());
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
