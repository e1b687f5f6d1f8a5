#include "tests/bench/timing/witness.hpp"

#include "tests/bench/timing/clock.hpp"
#include "tests/bench/timing/cyclictest.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::bench::timing;

namespace {

MonoTime at_us(std::int64_t us) { return MonoTime{} + microseconds(us); }

}  // namespace

TEST_GROUP(Stops){};

TEST(Stops, AnInterruptOnTimeIsNone) {
  const std::vector<MonoTime> interrupts{at_us(0), at_us(1000), at_us(2299), at_us(3000), at_us(4000)};
  CHECK(stops_of(interrupts, 0).empty());
  CHECK(stops_of({}, 0).empty());
}

TEST(Stops, ALateOneIsAStopSinceTheOneBefore) {
  const std::vector<MonoTime> interrupts{at_us(0),    at_us(1000),  at_us(2301),
                                         at_us(3000), at_us(17400), at_us(18000)};
  const auto stops = stops_of(interrupts, 1);
  CHECK_EQUAL(2U, stops.size());
  CHECK(stops[0].begin == at_us(1000) && stops[0].end == at_us(2301) && stops[0].cpu == 1);
  CHECK(stops[1].begin == at_us(3000) && stops[1].end == at_us(17400));
}

TEST(Stops, OfAnotherCoreDoNotCountForWhatRanOnThisOne) {
  const std::vector<Freeze> freezes{{at_us(1000), at_us(5000), 1}};
  CHECK(within_freeze(freezes, at_us(2000), at_us(2001), 1));
  CHECK(!within_freeze(freezes, at_us(2000), at_us(2001), 0));
  CHECK(within_freeze(freezes, at_us(2000), at_us(2001)));  // of an unknown core
}

TEST(Stops, AreToldInWords) {
  const std::vector<Freeze> freezes{{at_us(0), at_us(2000), 0}, {at_us(0), at_us(40'000), 1}};
  CHECK_EQUAL(std::string("2 stops of a core, 42 ms in all, longest 40 ms"),
              freezes_in_words(freezes, Witness::By::interrupts));
  CHECK_EQUAL(std::string("2 stops of a core or late wake-ups on it, 42 ms in all, longest 40 ms"),
              freezes_in_words(freezes, Witness::By::wake_ups));
}

TEST_GROUP(CoreInterrupts){};

TEST(CoreInterrupts, ComeAtWholeMillisecondsWhereTheKernelGivesThem) {
  auto interrupts = bench::timing::CoreInterrupts::open(0);
  if (!interrupts) return;  // not root, or forbidden here
  const MonoTime begin = now();
  while (now() - begin < milliseconds(60)) {
  }
  std::vector<MonoTime> instants;
  interrupts->take(instants);
  const MonoTime end = now();
  // A stop of the machine may have left some out.
  CHECK(!instants.empty() && instants.size() <= static_cast<std::size_t>((end - begin).ns / 1'000'000 + 1));
  std::size_t in_place = 0;
  for (const MonoTime instant : instants) {
    CHECK(instant > begin - milliseconds(1) && instant <= end);
    if (instant.ns % 1'000'000 < 300'000) ++in_place;
  }
  CHECK(2 * in_place >= instants.size());  // others were held up
  for (std::size_t i = 1; i < instants.size(); ++i) CHECK(instants[i] > instants[i - 1]);
}

TEST_GROUP(CyclictestsWakeUps){};

TEST(CyclictestsWakeUps, AreDueEveryPeriodFromAWholeSecond) {
  const auto samples = wake_ups_of({microseconds(20), microseconds(30), microseconds(10)}, at_us(7'012'000),
                                   milliseconds(3), 1);
  CHECK_EQUAL(3U, samples.size());
  CHECK(samples[0].from == at_us(7'003'500) && samples[0].to == at_us(7'003'520));
  CHECK(samples[2].from == at_us(7'009'500) && samples[2].to == at_us(7'009'510));
  DOUBLES_EQUAL(10.0, samples[2].lateness_us, 1e-9);
  CHECK_EQUAL(1, samples[2].cpu);
  CHECK(wake_ups_of({}, at_us(0), milliseconds(3), 1).empty());
}

TEST(CyclictestsWakeUps, AreNotDueWhileItIsBusyWithALateOne) {
  // As strace of cyclictest shows: after one 14.7 ms late the next is due 15 ms after it, in the series.
  const auto samples =
      wake_ups_of({microseconds(20), microseconds(14'669), microseconds(3'000), microseconds(1)},
                  at_us(7'012'000), milliseconds(3), -1);
  CHECK(samples[1].from == at_us(7'006'500) && samples[1].to == at_us(7'021'169));
  CHECK(samples[2].from == at_us(7'021'500));
  CHECK(samples[3].from == at_us(7'024'500));  // woken just when it was due: not passed
}

TEST(CyclictestsWakeUps, BelongToTheSecondBeforeTheFirstWasHeardOf) {
  const auto late = wake_ups_of({microseconds(600'000)}, at_us(7'010'000), milliseconds(3), -1);
  CHECK(late[0].from == at_us(6'003'500));
}
