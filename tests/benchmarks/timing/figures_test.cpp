#include <numeric>

#include "tests/benchmarks/timing/figures.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::benchmarks::timing;

TEST_GROUP(TimingFigures){std::vector<double> up_to(int n)
                              const {std::vector<double> values(static_cast<std::size_t>(n));
std::iota(values.begin(), values.end(), 1.0);
return values;
}
}
;

TEST(TimingFigures, PercentilesAreOfTheNearestRank) {
  const Percentiles p = percentiles(up_to(1000));
  CHECK_EQUAL(1000U, p.count);
  DOUBLES_EQUAL(500.0, p.p50_us, 0.0);
  DOUBLES_EQUAL(990.0, p.p99_us, 0.0);
  DOUBLES_EQUAL(999.0, p.p999_us, 0.0);
  DOUBLES_EQUAL(1000.0, p.max_us, 0.0);
}

TEST(TimingFigures, PercentilesOfNothingAreZero) {
  CHECK_EQUAL(0U, percentiles({}).count);
  DOUBLES_EQUAL(0.0, percentiles({}).max_us, 0.0);
}

TEST(TimingFigures, SamplesThatAFreezeTouchesAreLeftOut) {
  const std::vector<Freeze> freezes{{from_ns(100), from_ns(200)}};
  const std::vector<Sample> samples{{from_ns(10), from_ns(99), 1.0},
                                    {from_ns(10), from_ns(100), 2.0},
                                    {from_ns(150), from_ns(160), 3.0},
                                    {from_ns(200), from_ns(300), 4.0},
                                    {from_ns(201), from_ns(300), 5.0}};
  CHECK_EQUAL((std::vector<double>{1.0, 5.0}), outside(samples, freezes));
  CHECK_EQUAL(5U, latenesses(samples).size());
}

TEST(TimingFigures, RatiosAreOfEachPercentile) {
  CHECK_EQUAL(std::string("0.5 0.1 2 1"), ratios({9, 1.0, 1.0, 6.0, 7.0}, {9, 2.0, 10.0, 3.0, 7.0}));
}

TEST(TimingFigures, AnExceedanceFallsFromAllToOne) {
  const Curve curve = exceedance("x", up_to(1000));
  CHECK(curve.x.size() == curve.y.size() && curve.x.size() > 50);
  DOUBLES_EQUAL(1.0, curve.y.front(), 0.0);
  CHECK(curve.y.back() < 0.0011);
  for (std::size_t k = 0; k < curve.x.size(); ++k) {
    // Of 1, 2, ... 1000 the share above x is (1000 - x) / 1000, to one rank.
    DOUBLES_EQUAL(curve.y[k], (1000.0 - curve.x[k]) / 1000.0, 0.0021);
  }
}

TEST(TimingFigures, AFlashOfTheJournalIsLateByItsIssue) {
  strobe_msgs::event_t event{};
  event.kind = strobe_msgs::event_t::FLASH;
  event.commanded_ns = 5'000;
  event.issue_start_ns = 7'000;
  const auto flash = flash_of(event, 1);
  CHECK(flash && flash->from == from_ns(5'000) && flash->to == from_ns(7'000) && flash->cpu == 1);
  DOUBLES_EQUAL(2.0, flash->lateness_us, 1e-9);
}

TEST(TimingFigures, AFlashTooLateToBeIssuedCountsAsIssuedThen) {
  strobe_msgs::event_t event{};
  event.kind = strobe_msgs::event_t::SHOT_ABORTED;
  event.device_time_ns = 9'000'000;
  event.detail = "flash 12 would have been 1730 us late";
  const auto flash = flash_of(event, -1);
  CHECK(flash && flash->to == from_ns(9'000'000));
  DOUBLES_EQUAL(1730.0, flash->lateness_us, 1e-9);
  event.detail = "e-stop";
  CHECK(!flash_of(event, -1));
}
