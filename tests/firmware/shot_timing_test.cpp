#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "firmware/core/shot_timing.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

namespace {

constexpr MonoTime at_us(std::int64_t us) { return from_ns(us * 1000); }

}  // namespace

TEST_GROUP(ShotTiming) {
  ShotTiming timing;
  ShotRecord shot;

  FlashRecord& flash(std::int64_t commanded_us, std::int64_t issue_end_us) {
    FlashRecord flash;
    flash.commanded = at_us(commanded_us);
    flash.issue_start = at_us(issue_end_us - 1);
    flash.issue_end = at_us(issue_end_us);
    shot.flashes.push_back(flash);
    return shot.flashes.back();
  }
  const TimingHistogram& of(TimingQuantity quantity) { return timing.of(quantity); }
};

TEST(ShotTiming, ToldOfAnIssuedFlashCountsItsLatenessAndItsCall) {
  timing.issued(at_us(1000), at_us(1004), at_us(1005));
  CHECK_EQUAL(4000, of(TimingQuantity::lateness).max().count());
  CHECK_EQUAL(1000, of(TimingQuantity::issue).max().count());
  CHECK_EQUAL(0, of(TimingQuantity::skew).count());
}

TEST(ShotTiming, TakesSkewAndEachLampsDelayFromWhatTheSensorsSaw) {
  FlashRecord& both = flash(0, 2);
  both.observed_a = at_us(14);
  both.observed_b = at_us(17);
  flash(3000, 3002).observed_b = at_us(3014);
  timing.seen(shot);
  CHECK_EQUAL(1, of(TimingQuantity::skew).count());
  CHECK_EQUAL(-3000, of(TimingQuantity::skew).max().count());
  CHECK_EQUAL(1, of(TimingQuantity::lamp_delay_a).count());
  CHECK_EQUAL(12'000, of(TimingQuantity::lamp_delay_a).max().count());
  CHECK_EQUAL(2, of(TimingQuantity::lamp_delay_b).count());
  CHECK_EQUAL(12'000, of(TimingQuantity::lamp_delay_b).min().count());
}

TEST(ShotTiming, TakesALampsDelayOnlyFromItsOwnSensor) {
  FlashRecord& only_a = flash(0, 2);
  only_a.lamps = Lamps::a;
  only_a.observed_a = at_us(14);
  only_a.observed_b = at_us(15);  // it saw the other lamp's light
  timing.seen(shot);
  CHECK_EQUAL(1, of(TimingQuantity::lamp_delay_a).count());
  CHECK_EQUAL(0, of(TimingQuantity::lamp_delay_b).count());
  CHECK_EQUAL(0, of(TimingQuantity::skew).count());
}

TEST(ShotTiming, TakesThePeriodsErrorFromTheSensorsThatSawBothFlashes) {
  FlashRecord& first = flash(0, 2);
  first.observed_a = at_us(14);
  first.observed_b = at_us(94);  // a sensor that is 80 us slower
  FlashRecord& second = flash(3000, 3002);
  second.observed_a = at_us(3019);  // 5 us late
  second.observed_b = at_us(3097);  // 3 us late
  flash(6000, 6002).observed_b = at_us(6094);
  timing.seen(shot);
  CHECK_EQUAL(2, of(TimingQuantity::period_error).count());
  CHECK_EQUAL(4000, of(TimingQuantity::period_error).max().count());
  CHECK_EQUAL(-3000, of(TimingQuantity::period_error).min().count());
}

TEST(ShotTiming, AFlashThatNobodySawMakesNoPeriod) {
  flash(0, 2).observed_a = at_us(14);
  flash(3000, 3002);
  flash(6000, 6002).observed_a = at_us(6014);
  timing.seen(shot);
  CHECK_EQUAL(0, of(TimingQuantity::period_error).count());
}

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(TimingHistogram) {
  std::unique_ptr<TimingHistogram> owned = std::make_unique<TimingHistogram>();
  TimingHistogram& histogram = *owned;

  static std::int64_t sum(const TimingHistogram::Coarse& coarse) {
    return std::accumulate(coarse.bins.begin(), coarse.bins.end(), std::int64_t{0});
  }
};

TEST(TimingHistogram, IsZeroBeforeTheFirst) {
  CHECK_EQUAL(0, histogram.count());
  CHECK_EQUAL(0, histogram.percentile(0.99).count());
  DOUBLES_EQUAL(0.0, histogram.sd_ns(), 0.0);
  CHECK_EQUAL(0u, histogram.coarse().count);
}

TEST(TimingHistogram, IsExactForSmallNumbersOfEitherSign) {
  for (int ns = -50; ns <= 50; ++ns) histogram.add(nanoseconds(ns));
  CHECK_EQUAL(-50, histogram.min().count());
  CHECK_EQUAL(-40, histogram.percentile(11.0 / 101.0).count());
  CHECK_EQUAL(0, histogram.percentile(0.5).count());
  CHECK_EQUAL(49, histogram.percentile(0.99).count());
  CHECK_EQUAL(50, histogram.percentile(1.0).count());
  DOUBLES_EQUAL(0.0, histogram.mean_ns(), 1e-12);
  DOUBLES_EQUAL(std::sqrt(850.0), histogram.sd_ns(), 1e-9);  // (101² - 1)/12
}

TEST(TimingHistogram, NeverGivesMoreThanTheLargest) {
  histogram.add(milliseconds(170));
  CHECK_EQUAL(Duration(milliseconds(170)).count(), histogram.percentile(0.999).count());
  CHECK_EQUAL(Duration(milliseconds(170)).count(), histogram.percentile(0.0).count());
}

TEST(TimingHistogram, TakesAnythingThatANumberHolds) {
  histogram.add(milliseconds(3'600'000));
  histogram.add(nanoseconds(INT64_MIN));
  histogram.add(nanoseconds(INT64_MAX));
  CHECK_EQUAL(INT64_MIN, histogram.min().count());
  CHECK_EQUAL(INT64_MAX, histogram.max().count());
  CHECK_EQUAL(3, histogram.count());
  CHECK(histogram.percentile(0.6) > milliseconds(10'000));
  CHECK_EQUAL(3, sum(histogram.coarse()));
}

TEST(TimingHistogram, AgreesWithSortingWithinAStep) {
  // 256 steps an octave: a bin is at most 1/256 of its value wide.
  std::mt19937_64 random(42);
  std::lognormal_distribution<double> magnitude(std::log(3000.0), 2.0);
  std::vector<std::int64_t> all;
  for (int i = 0; i < 20'000; ++i) {
    const double sign = i % 3 == 0 ? -1.0 : 1.0;
    all.push_back(static_cast<std::int64_t>(sign * magnitude(random)));
    histogram.add(nanoseconds(all.back()));
  }
  std::sort(all.begin(), all.end());
  for (const double share : {0.001, 0.01, 0.3, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size()))) - 1;
    const auto exact = static_cast<double>(all[rank]);
    const auto given = static_cast<double>(histogram.percentile(share).count());
    CHECK(given >= exact);
    CHECK(given <= exact + std::abs(exact) / 256.0 + 1.0);
  }
  CHECK_EQUAL(20'000, sum(histogram.coarse()));
}

TEST(TimingHistogram, ShowsTheMiddleInRoundBinsAndTheRestInTheOuterOnes) {
  // A lamp: 12 us ± 0.5 us, and one flash in a thousand 100 us late.
  std::mt19937_64 random(7);
  std::normal_distribution<double> delay(12'000.0, 500.0);
  for (int i = 0; i < 10'000; ++i)
    histogram.add(nanoseconds(static_cast<std::int64_t>(delay(random)) + (i % 1000 == 0 ? 100'000 : 0)));
  const auto coarse = histogram.coarse();
  CHECK_EQUAL(200,
              coarse.width.count());  // 99 % of a normal are 5.15 sd = 2.6 us wide: over 22 bins, rounded up
  CHECK_EQUAL(0, coarse.first.count() % 200);
  CHECK(coarse.count >= 12 && coarse.count <= 16);
  CHECK(coarse.bins[coarse.count - 1] >= 10);
  CHECK_EQUAL(10'000, sum(coarse));
  const auto most = std::max_element(coarse.bins.begin(), coarse.bins.end()) - coarse.bins.begin();
  const double middle_ns = static_cast<double>(coarse.first.count() + coarse.width.count() * most) + 100.0;
  DOUBLES_EQUAL(12'000.0, middle_ns, 250.0);
}

TEST(TimingHistogram, OfOneValueHasOneBin) {
  histogram.add(nanoseconds(-1234));
  const auto coarse = histogram.coarse();
  CHECK_EQUAL(1u, coarse.count);
  CHECK_EQUAL(1, coarse.bins[0]);
  CHECK(coarse.first.count() <= -1234 && -1234 < (coarse.first + coarse.width).count());
}

// 22 bins hold the middle 99 %: of so few values, all. No bin is narrower than four steps of the table, which are
// 1 ns wide below 512 ns, 2 ns up to 1024 ns and 4 ns above.
TEST(TimingHistogram, MakesTheNarrowestRoundBinsThatHoldTheMiddle) {
  struct Row {
    std::vector<std::int64_t> values;
    std::int64_t first, width;
    std::size_t bins;
  };
  std::vector<std::int64_t> from_100(23);
  std::iota(from_100.begin(), from_100.end(), 100);
  std::vector<std::int64_t> one_more = from_100;
  one_more.push_back(123);
  for (const Row& row :
       {Row{from_100, 100, 1, 23}, Row{one_more, 100, 2, 12}, Row{{100, 1600}, 100, 100, 16},
        Row{{600}, 600, 10, 1}, Row{{1000, 1030}, 1000, 20, 2}, Row{{-1030, -1000}, -1040, 20, 3}}) {
    auto some = std::make_unique<TimingHistogram>();
    for (const std::int64_t value : row.values) some->add(nanoseconds(value));
    const auto coarse = some->coarse();
    CHECK_EQUAL(row.first, coarse.first.count());
    CHECK_EQUAL(row.width, coarse.width.count());
    CHECK_EQUAL(row.bins, coarse.count);
    CHECK_EQUAL(static_cast<std::int64_t>(row.values.size()), sum(coarse));
  }
}
