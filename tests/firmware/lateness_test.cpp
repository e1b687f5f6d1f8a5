#include "firmware/core/lateness.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(Lateness) { LatenessHistogram histogram; };

TEST(Lateness, IsZeroBeforeTheFirst) {
  CHECK_EQUAL(0, histogram.count());
  CHECK_EQUAL(0, histogram.percentile(0.99).ns);
}

TEST(Lateness, CountsAnEarlyOneAsZero) {
  histogram.add(nanoseconds(-50));
  CHECK_EQUAL(1, histogram.count());
  CHECK_EQUAL(0, histogram.percentile(1.0).ns);
}

TEST(Lateness, IsExactForSmallNumbers) {
  for (int ns = 1; ns <= 100; ++ns) histogram.add(nanoseconds(ns));
  CHECK_EQUAL(50, histogram.percentile(0.5).ns);
  CHECK_EQUAL(99, histogram.percentile(0.99).ns);
  CHECK_EQUAL(100, histogram.max().ns);
}

TEST(Lateness, NeverGivesMoreThanTheLargest) {
  histogram.add(milliseconds(170));
  CHECK_EQUAL(milliseconds(170).ns, histogram.percentile(0.999).ns);
}

TEST(Lateness, TakesEvenAnHour) {
  histogram.add(milliseconds(3'600'000));
  CHECK_EQUAL(milliseconds(3'600'000).ns, histogram.max().ns);
  CHECK(histogram.percentile(0.5) > milliseconds(10'000));
}

TEST(Lateness, AgreesWithSortingWithinAStep) {
  // 64 steps an octave: a bin is at most 1/64 of its value wide.
  std::mt19937_64 random(42);
  std::lognormal_distribution<double> lateness(std::log(3000.0), 2.0);
  std::vector<std::int64_t> all;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(static_cast<std::int64_t>(lateness(random)));
    histogram.add(nanoseconds(all.back()));
  }
  std::sort(all.begin(), all.end());
  for (const double share : {0.001, 0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size()))) - 1;
    const auto exact = static_cast<double>(all[rank]);
    const auto given = static_cast<double>(histogram.percentile(share).ns);
    CHECK(given >= exact);
    CHECK(given <= exact * (1.0 + 1.0 / 64.0) + 1.0);
  }
}
