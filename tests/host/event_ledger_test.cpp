// Which events are missing, and what is asked for when. Time is virtual.
#include "host/messages/event_ledger.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <set>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using strobe::host::EndedBoot;
using strobe::host::EventLedger;

constexpr HostTime at_ms(std::int64_t ms) { return HostTime{milliseconds{ms}}; }
constexpr std::int64_t kBoot = 0x7700;

void everything_comes_at_loss(double loss) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 generator(seed);
    std::bernoulli_distribution lost(loss);
    EventLedger ledger(true);
    std::set<std::int64_t> here;
    const auto send = [&](std::int64_t s, HostTime now) {
      if (!lost(generator) && ledger.add(kBoot, s, now)) here.insert(s);
    };
    for (std::int64_t s = 1; s <= 3000; ++s) send(s, at_ms(s));
    ledger.status(kBoot, 3000, at_ms(3000));
    HostTime now = at_ms(3000);
    for (int turn = 0; turn < 1000 && !ledger.complete(); ++turn, now += milliseconds{20}) {
      for (const EventRange& range : ledger.due(now)) {
        if (lost(generator)) continue;
        for (std::int64_t s = range.sequences.first; s <= std::min<std::int64_t>(range.sequences.last, 3000);
             ++s)
          send(s, now);
      }
    }
    LONGS_EQUAL(3000, here.size());
    LONGS_EQUAL(0, ledger.missing());
  }
}

}  // namespace

TEST_GROUP(EventLedgerOfAHost) {
  EventLedger ledger{true};

  void add(std::int64_t first, std::int64_t last, HostTime now = {}) {
    for (std::int64_t s = first; s <= last; ++s) ledger.add(kBoot, s, now);
  }
};

TEST(EventLedgerOfAHost, AnUnbrokenSequenceMissesNothing) {
  ledger.status(kBoot, 0, {});
  add(1, 500);
  LONGS_EQUAL(0, ledger.missing());
  LONGS_EQUAL(500, ledger.received());
  CHECK_TRUE(ledger.due(at_ms(1000)).empty());
  CHECK_TRUE(ledger.complete());
}

TEST(EventLedgerOfAHost, AnEventThatComesTwiceIsNewOnce) {
  CHECK_TRUE(ledger.add(kBoot, 1, {}));
  CHECK_FALSE(ledger.add(kBoot, 1, {}));
  CHECK_FALSE(ledger.add(kBoot, 0, {}));
  CHECK_FALSE(ledger.add(kBoot, -5, {}));
  LONGS_EQUAL(1, ledger.received());
}

TEST(EventLedgerOfAHost, AGapIsAskedForAfterAGraceForReordering) {
  ledger.status(kBoot, 1, {});
  add(1, 10, at_ms(1000));
  add(13, 20, at_ms(1000));
  LONGS_EQUAL(2, ledger.missing());
  CHECK_TRUE(ledger.due(at_ms(1050)).empty());
  CHECK_EQUAL(std::vector{(EventRange{kBoot, {11, 12}})}, ledger.due(at_ms(1200)));
  CHECK_TRUE(ledger.due(at_ms(1250)).empty());     // just asked
  LONGS_EQUAL(1, ledger.due(at_ms(1500)).size());  // and again
  add(11, 12, at_ms(1600));
  CHECK_TRUE(ledger.due(at_ms(3000)).empty());
}

TEST(EventLedgerOfAHost, ReorderedEventsCloseTheirOwnGap) {
  ledger.status(kBoot, 0, {});
  for (const std::int64_t s : {2, 1, 4, 3, 6, 5}) ledger.add(kBoot, s, at_ms(1000));
  LONGS_EQUAL(0, ledger.missing());
  CHECK_TRUE(ledger.due(at_ms(2000)).empty());
}

TEST(EventLedgerOfAHost, AStatusTellsOfALossAtTheEnd) {
  add(1, 10);
  ledger.status(kBoot, 12, at_ms(1000));
  CHECK_EQUAL(std::vector{(EventRange{kBoot, {11, 12}})}, ledger.due(at_ms(1200)));
}

TEST(EventLedgerOfAHost, AHostThatFiresWantsWhatWasBeforeItCameAndAPassiveOneDoesNot) {
  EventLedger firing(true), passive(false);
  for (EventLedger* each : {&firing, &passive}) {
    each->status(kBoot, 40, at_ms(1000));
    each->add(kBoot, 41, at_ms(1000));
  }
  LONGS_EQUAL(40, firing.missing());
  LONGS_EQUAL(0, passive.missing());
}

TEST(EventLedgerOfAHost, LossesNearEachOtherAreOneQuestionAndLongOnesAreCut) {
  ledger.status(kBoot, 5000, {});
  for (std::int64_t s = 1; s <= 200; s += 2) ledger.add(kBoot, s, {});  // every second one is lost
  const auto asks = ledger.due(at_ms(1000));
  CHECK_TRUE(asks.size() <= 8);
  for (const EventRange& range : asks) CHECK_TRUE(range.sequences.last - range.sequences.first < 512);
  LONGS_EQUAL(2, asks[0].sequences.first);
}

TEST(EventLedgerOfAHost, ALostSummaryIsAskedForFirst) {
  ledger.status(kBoot, 1, {});
  add(1, 5);
  add(9, 9);
  ledger.request_again(kBoot, 9);
  const auto asks = ledger.due(at_ms(1000));
  LONGS_EQUAL(2, asks.size());
  CHECK_EQUAL((EventRange{kBoot, {9, 9}}), asks[0]);
  ledger.add(kBoot, 9, at_ms(1100));  // it came again
  CHECK_EQUAL((EventRange{kBoot, {6, 8}}), ledger.due(at_ms(2000))[0]);
}

TEST(EventLedgerOfAHost, WhatAnEndedBootMayStillHoldIsAskedForUntilNothingComes) {
  ledger.status(kBoot, 3, {});
  add(1, 3);
  ledger.status(kBoot + 1, 0, at_ms(100));  // killed and started anew; its last events never came
  CHECK_FALSE(ledger.complete());
  const auto asks = ledger.due(at_ms(1000));
  LONGS_EQUAL(1, asks.size());
  LONGS_EQUAL(kBoot, asks[0].boot_id);
  LONGS_EQUAL(4, asks[0].sequences.first);
  ledger.add(kBoot, 4, at_ms(1100));
  HostTime now = at_ms(2000);
  int more = 0;
  while (!ledger.complete() && more < 100) {
    more += static_cast<int>(ledger.due(now).size());
    now += milliseconds{300};
  }
  LONGS_EQUAL(8, more);  // the answer put the count back to its start
  LONGS_EQUAL(4, ledger.received());
}

TEST(EventLedgerOfAHost, WhatAnEndedBootHoldsIsAskedForToItsEndAndNoFurther) {
  ledger.status(kBoot, 3, {});
  add(1, 3);
  ledger.status(kBoot + 1, 0, at_ms(100));
  const EndedBoot ended{kBoot, 5};
  ledger.earlier({&ended, 1}, at_ms(100));
  CHECK_FALSE(ledger.ended_and_complete(kBoot));
  CHECK_EQUAL(std::vector{(EventRange{kBoot, {4, 5}})}, ledger.due(at_ms(1000)));
  add(4, 5, at_ms(1100));
  CHECK_TRUE(ledger.ended_and_complete(kBoot));
  CHECK_TRUE(ledger.complete());
  CHECK_TRUE(ledger.due(at_ms(2000)).empty());
}

TEST(EventLedgerOfAHost, ABootBetweenTwoThatWereHeardIsWantedAndOneBeforeThemIsNot) {
  const std::array<EndedBoot, 3> ended{{{kBoot + 2, 7}, {kBoot + 1, 9}, {kBoot, 11}}};
  ledger.add(kBoot + 1, 1, {});  // heard before this host's time, too
  ledger.status(kBoot + 3, 0, {});
  ledger.earlier(ended, {});
  LONGS_EQUAL(8 + 7, ledger.missing());
  EventLedger other(true);
  other.status(kBoot + 3, 0, {});
  other.earlier(ended, {});
  LONGS_EQUAL(0, other.missing());
}

TEST(EventLedgerOfAHost, KnowsWhichRangesAreHere) {
  add(2, 5);
  add(7, 7);
  CHECK_TRUE(ledger.holds(kBoot, 2, 5));
  CHECK_TRUE(ledger.holds(kBoot, 3, 4));
  CHECK_TRUE(ledger.holds(kBoot, 7, 7));
  CHECK_FALSE(ledger.holds(kBoot, 1, 2));
  CHECK_FALSE(ledger.holds(kBoot, 5, 7));
  CHECK_FALSE(ledger.holds(kBoot, 8, 8));
  CHECK_FALSE(ledger.holds(kBoot + 1, 2, 2));
}

TEST(EventLedgerOfAHost, EveryLostSummaryIsRemembered) {
  ledger.status(kBoot, 9, {});
  add(1, 9);
  ledger.request_again(kBoot, 4);
  ledger.request_again(kBoot, 9);
  LONGS_EQUAL(2, ledger.due(at_ms(1000)).size());
  CHECK_FALSE(ledger.complete());
  ledger.cancel_request(kBoot, 9);
  ledger.add(kBoot, 4, at_ms(1100));
  CHECK_TRUE(ledger.complete());
}

TEST(EventLedgerOfAHost, ASummaryThatAnEndedBootNeverWroteIsNotAskedForForEver) {
  ledger.add(kBoot, 1, {});
  const EndedBoot ended{kBoot, 1};
  ledger.status(kBoot + 1, 0, {});
  ledger.earlier({&ended, 1}, {});
  ledger.request_again(kBoot, 1);
  int asks = 0;
  for (HostTime now = at_ms(1000); asks < 100 && !ledger.complete(); now += milliseconds{300})
    asks += static_cast<int>(ledger.due(now).size());
  LONGS_EQUAL(24, asks);
}

TEST(EventLedgerOfAHost, AtHalfLossEverythingComesInTheEnd) { everything_comes_at_loss(0.5); }

TEST(EventLedgerOfAHost, AtTwentyPerCentLossEverythingComesInTheEnd) { everything_comes_at_loss(0.2); }
