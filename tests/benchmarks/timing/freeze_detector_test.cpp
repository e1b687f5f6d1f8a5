#include "tests/benchmarks/timing/freeze_detector.hpp"

#include "tests/benchmarks/timing/figures.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::benchmarks::timing;

namespace {

MonoTime at_us(std::int64_t us) { return MonoTime{} + microseconds(us); }

std::vector<CoreInterrupt> at_each_us(const std::vector<std::int64_t>& instants, bool in_kernel = false) {
  std::vector<CoreInterrupt> interrupts;
  for (const std::int64_t us : instants) interrupts.push_back({at_us(us), in_kernel});
  return interrupts;
}

}  // namespace

TEST_GROUP(Stops){};

TEST(Stops, AnInterruptOnTimeIsNone) {
  const auto interrupts = at_each_us({0, 1000, 2299, 3000, 4000});
  CHECK(stops_of(interrupts, 0).empty());
  CHECK(stops_of({}, 0).empty());
}

TEST(Stops, ALateOneIsAStopSinceTheOneBefore) {
  const auto interrupts = at_each_us({0, 1000, 2301, 3000, 17400, 18000});
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
              freezes_in_words(freezes, FreezeDetector::Method::interrupts));
  CHECK_EQUAL(std::string("2 stops of a core or late wake-ups on it, 42 ms in all, longest 40 ms"),
              freezes_in_words(freezes, FreezeDetector::Method::wake_ups));
}

TEST_GROUP(KernelActivity){};

TEST(KernelActivity, CountsLooksAtTheCoreOfWhatWasLateOutsideFreezes) {
  const std::vector<std::vector<CoreInterrupt>> interrupts{at_each_us({1000, 2000, 3000}),
                                                           at_each_us({1000, 2000, 3000, 9000}, true)};
  const std::vector<Freeze> freezes{{at_us(8000), at_us(9500), 1}};
  const std::vector<Sample> samples{sample_of(at_us(1500), at_us(3000), 1),   // one look, in the kernel
                                    sample_of(at_us(1500), at_us(3500), 0),   // two looks, in user code
                                    sample_of(at_us(1990), at_us(2010), 1),   // not late
                                    sample_of(at_us(8500), at_us(9200), 1),   // in a freeze
                                    sample_of(at_us(1500), at_us(3000), -1),  // where it ran is not known
                                    sample_of(at_us(1500), at_us(3000), 2)};  // a core that nobody watched
  const KernelActivity held = kernel_activity(samples, freezes, interrupts, microseconds(100));
  CHECK_EQUAL(2U, held.late);
  CHECK_EQUAL(3U, held.interrupts);
  CHECK_EQUAL(1U, held.in_kernel);
  CHECK_EQUAL(
      std::string(
          "2 later than 100 us outside freezes, meanwhile their core was in the kernel at 1 of 3 looks"),
      in_words(held, microseconds(100)));
  CHECK_EQUAL(0U, kernel_activity(samples, freezes, {}, microseconds(100)).late);
}

TEST_GROUP(CoreInterrupts){};

TEST(CoreInterrupts, ComeOnceAMillisecondAtMostWhereTheKernelGivesThem) {
  const MonoTime begin = now();
  auto interrupts = benchmarks::timing::CoreInterrupts::open(0);
  if (!interrupts) return;  // not root, or forbidden here
  const MonoTime open = now();
  while (now() - open < milliseconds(60)) {
  }
  std::vector<CoreInterrupt> taken;
  interrupts->take(taken);
  const MonoTime end = now();
  // A stop of the machine may have left some out.
  CHECK(!taken.empty() && taken.size() <= static_cast<std::size_t>((end - begin) / milliseconds(1) + 1));
  for (const CoreInterrupt& each : taken) CHECK(each.at > begin && each.at <= end);
  for (std::size_t i = 1; i < taken.size(); ++i) CHECK(taken[i].at > taken[i - 1].at);
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
  CHECK_EQUAL(at_us(7'021'500), samples[2].from);
  CHECK_EQUAL(at_us(7'024'500), samples[3].from);  // woken just when it was due: not passed
}

TEST(CyclictestsWakeUps, BelongToTheSecondBeforeTheFirstWasHeardOf) {
  const auto late = wake_ups_of({microseconds(600'000)}, at_us(7'010'000), milliseconds(3), -1);
  CHECK_EQUAL(at_us(6'003'500), late[0].from);
}
