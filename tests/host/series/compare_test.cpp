// Differences of two series.
#include "host/series/compare.hpp"

#include <cmath>
#include <random>

#include "tests/host/series/simulated_series.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using namespace strobe::test;
using reduction::Quantity;

namespace {

QuantityDifference vx(const Comparison& comparison) { return *comparison.of(Quantity::vx_td_mps); }

const std::vector<double> kFirst{10.0, 12.0, 14.0}, kSecond{20.0, 21.0, 22.0, 23.0};

std::vector<double> normal_values(int n, double mean, double sd, std::mt19937_64& random) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(std::normal_distribution<double>(mean, sd)(random));
  return values;
}

}  // namespace

TEST_GROUP(Comparison){};

// Variances 4/3 and (5/3)/4 = 5/12: 7/4 together. Welch: (7/4)^2 / ((4/3)^2/2 + (5/12)^2/3) = 3.2347, t = 7.1813, whose
// tails, by the midpoint rule over Student's density, hold 0.0043085.
TEST(Comparison, IsWelchsWithoutSharedSources) {
  const QuantityDifference d = vx(compare(series_of(series_shots(kFirst)), series_of(series_shots(kSecond))));
  DOUBLES_EQUAL(-9.5, d.difference, 1e-12);
  DOUBLES_EQUAL(std::sqrt(1.75), d.total_sd, 1e-12);
  DOUBLES_EQUAL(3.0625 / (16.0 / 18.0 + 25.0 / 432.0), *d.degrees_of_freedom, 1e-9);
  CHECK_TRUE(d.decided);
  DOUBLES_EQUAL(0.0043085, d.p_value, 1e-6);
}

TEST(Comparison, CancelsWhatBothShareAndNotWhatTheyDoNot) {
  auto first = series_shots(kFirst, 0.5), second = series_shots(kSecond, 0.75);
  DOUBLES_EQUAL(0.25, vx(compare(series_of(first), series_of(second))).shared_sd, 1e-12);
  for (SeriesShot& shot : second) shot.calibration = "another camera's";
  DOUBLES_EQUAL(std::hypot(0.5, 0.75), vx(compare(series_of(first), series_of(second))).shared_sd, 1e-12);
}

TEST(Comparison, NeedsTwoShotsOfEach) {
  const auto comparison = compare(series_of(series_shots({1.0})), series_of(series_shots(kSecond)));
  CHECK_FALSE(comparison.of(Quantity::vx_td_mps).has_value());
}

// Of many shots with sd 1, a difference of 1 needs n = 2 (1.96 + 0.8416)^2 = 15.7 of each with normal quantiles; with
// Student's t of 30 degrees of freedom 2 (2.042 + 0.8538)^2 = 16.8, so that 17 suffice.
TEST(Comparison, CountsTheShotsThatWouldDecide) {
  const double a = std::sqrt(0.5);  // two values at ±a have sd 1
  const auto first = series_of(series_shots({-a, a})), second = series_of(series_shots({-a, a}));
  const QuantityDifference d = vx(compare(first, second, 1.0));
  CHECK_EQUAL(15, d.more_first.value());
  CHECK_EQUAL(15, d.more_second.value());
  CHECK_FALSE(vx(compare(first, second)).more_first.has_value());  // none was found
}

TEST(Comparison, SaysWhereNoNumberOfShotsWouldDo) {
  auto first = series_shots({-1.0, 1.0}, 0.5), second = series_shots({-1.0, 1.0});
  CHECK_FALSE(
      vx(compare(series_of(first), series_of(second), 1.4)).more_first.has_value());  // 2.80 * 0.5 = 1.4007
  CHECK_TRUE(vx(compare(series_of(first), series_of(second), 1.5)).more_first.has_value());
}

TEST(Comparison, AsksForNoMoreOfSeriesThatHaveEnough) {
  std::mt19937_64 random(3);
  const auto first = series_of(series_shots(normal_values(40, 0.0, 1.0, random)));
  const auto second = series_of(series_shots(normal_values(5, 5.0, 1.0, random)));
  const QuantityDifference d = vx(compare(first, second));
  CHECK_EQUAL(0, d.more_first.value());
  CHECK_EQUAL(0, d.more_second.value());
}

// 4,000 pairs: the share within scatters by 0.34 %; Welch's interval of 5 and 9 shots is within 0.3 % of 95 %.
TEST(Comparison, IntervalHoldsTheTrueDifferenceAsOftenAsItSays) {
  std::mt19937_64 random(4);
  int held = 0;
  constexpr int kPairs = 4000;
  for (int i = 0; i < kPairs; ++i) {
    const double shared = std::normal_distribution<double>()(random);
    auto first = normal_values(9, 3.0 + 0.5 * shared, 1.0, random);
    auto second = normal_values(5, 1.0 + 0.2 * shared, 2.0, random);
    const auto d = vx(compare(series_of(series_shots(first, 0.5)), series_of(series_shots(second, 0.2))));
    if (std::abs(d.difference - 2.0) < d.expanded_uncertainty) ++held;
  }
  DOUBLES_EQUAL(0.95, held / static_cast<double>(kPairs), 0.015);
}
