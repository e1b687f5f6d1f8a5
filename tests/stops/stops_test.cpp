// A stop stays a stop, whatever is lost, late or repeated between firmware and hosts.
#include <cstdio>

#include "tests/stops/search.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::stops;

namespace {

using firmware::InterlockEvent;
using firmware::TransitionTable;

Found searched(const char* what, const Limits& limits, const Fault& fault = {}) {
  const Found found = search(limits, fault);
  std::printf("%s: %s\n", what, in_words(found).c_str());
  return found;
}

TransitionTable without_guard(InterlockEvent event, std::uint32_t guards) {
  TransitionTable table = firmware::kTransitionTable;
  table[static_cast<std::size_t>(event)].guards &= ~guards;
  return table;
}

TransitionTable without_latch() {
  TransitionTable table = firmware::kTransitionTable;
  for (firmware::TransitionRow& row : table) row.actions &= ~firmware::action::latch_stop;
  return table;
}

}  // namespace

TEST_GROUP(Stops) {
  static constexpr Limits kSafety{.shots = 1, .retries = 0, .ways_back = false};

  void expect(const char* wrong, const char* what, const Limits& limits, const Fault& fault) {
    STRCMP_CONTAINS(wrong, searched(what, limits, fault).wrong.c_str());
  }
};

// What is wrong in a state from which a person's one act does not lead to a shot is found by the same searches.
TEST(Stops, NothingIsTriggeredAfterAStopWithoutAPersonInASeriesOfSeveralShots) {
  const Found found = searched("a series with retries", {});
  CHECK_EQUAL("", found.wrong);
  CHECK(found.triggers > 0);
}

TEST(Stops, NorAfterFaults) {
  const Found found = searched("faults", {.shots = 1, .retries = 0, .faults = true});
  CHECK_EQUAL("", found.wrong);
  CHECK(found.triggers > 0);
}

TEST(Stops, NorByAFirmwareThatStartsAnew) {
  const Found found = searched("restarts", {.shots = 1, .retries = 0, .restarts = true});
  CHECK_EQUAL("", found.wrong);
  CHECK(found.triggers > 0);
}

TEST(Stops, TheFirmwareAloneKeepsThemAgainstASeriesThatHearsOfNone) {
  const Found found = searched("a deaf series", {.shots = 1, .retries = 0}, {.deaf_series = true});
  CHECK_EQUAL("", found.wrong);
  CHECK(found.triggers > 0);
}

// A gap that is left, so that nobody takes it for closed: whoever closes it turns its test around.
TEST(Stops, LeftOpenAFirmwareThatStartsAnewForgetsAStopOfASeriesThatHasNotBegun) {
  Limits limits = kSafety;
  limits.restarts = limits.strict_restart = true;
  expect("AFTER A STOP", "a stop before the firmware's start", limits, {});
}

TEST(Stops, WouldNoticeAnInterlockThatForgetsAStop) {
  const TransitionTable table = without_latch();
  expect("AFTER A STOP", "no stop is latched", kSafety, {.table = &table});
}

TEST(Stops, WouldNoticeAnInterlockThatArmsForAHostWhosePersonDidNotAct) {
  const TransitionTable table = without_guard(InterlockEvent::arm, firmware::guard::reset_by_host);
  expect("AFTER A STOP", "another host's RESET counts", kSafety, {.table = &table});
}

TEST(Stops, WouldNoticeAnInterlockThatTakesAResetFromBeforeTheStop) {
  const TransitionTable table = without_guard(InterlockEvent::reset, firmware::guard::after_stops);
  expect("AFTER A STOP", "an older act counts", kSafety, {.table = &table});
}

TEST(Stops, WouldNoticeAHostWhoseResetTellsWhenItWasSent) {
  expect("AFTER A STOP", "RESET tells when it was sent", kSafety, {.act_as_sent = true});
}

TEST(Stops, WouldNoticeADisarmThatIsSentOnce) {
  Limits limits = kSafety;
  limits.ways_back = true;
  expect("A DISARM IS NEVER CONFIRMED", "DISARM is sent once", limits, {.disarm_once = true});
}

TEST(Stops, WouldNoticeADisarmThatIsBelievedUnheard) {
  expect("CONFIRMED DISARM", "DISARM counts as confirmed once it is sent", kSafety,
         {.disarm_believed = true});
}

TEST(Stops, WouldNoticeARigThatIsStoppedForGood) {
  TransitionTable table = firmware::kTransitionTable;
  table[static_cast<std::size_t>(InterlockEvent::reset)]
      .in[static_cast<std::size_t>(firmware::State::stopped)]
      .next = firmware::State::stopped;
  expect("DOES NOT LEAD TO A SHOT", "no RESET ends a stop", {}, {.table = &table});
}
