// What a series says: scatter, standard error, what the shots share, and the total.
#include <algorithm>
#include <cmath>
#include <random>
#include <rapidcheck.h>
#include <vector>

#include "host/series/compare.hpp"
#include "host/series/series.hpp"
#include "tests/host/series/simulated_series.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using namespace strobe::test;
using reduction::Quantity;

namespace {

const QuantitySummary& of(const SeriesSummary& summary, Quantity q) {
  return summary.quantities[static_cast<std::size_t>(q)];
}

std::vector<double> some_values() {
  std::vector<double> values;
  const int n = *rc::gen::inRange(2, 12);
  for (int i = 0; i < n; ++i) values.push_back(*rc::gen::inRange(-1000, 1000) / 64.0);
  return values;
}

}  // namespace

TEST_GROUP(Series){};

// Of 10, 12, 14: sd 2, standard error 2/sqrt(3). The scale's 0.5 does not become smaller: total sqrt(4/3 + 1/4).
// Welch-Satterthwaite: 2 * ((4/3 + 1/4) / (4/3))^2 = 2.82; Student's t of that is 3.30 (tables: 4.30 of 2, 3.18 of 3).
TEST(Series, TellsApartScatterStandardErrorSharedPartAndTotal) {
  const SeriesSummary summary = summarize("zero 23", series_shots({10.0, 12.0, 14.0}, 0.5));
  const QuantitySummary& vx = of(summary, Quantity::vx_td_mps);
  CHECK_EQUAL(3, vx.n);
  DOUBLES_EQUAL(12.0, vx.mean, 1e-12);
  DOUBLES_EQUAL(2.0, *vx.scatter_sd, 1e-12);
  DOUBLES_EQUAL(2.0 / std::sqrt(3.0), *vx.standard_error, 1e-12);
  DOUBLES_EQUAL(0.5, vx.shared_sd, 1e-12);
  DOUBLES_EQUAL(std::sqrt(4.0 / 3.0 + 0.25), *vx.total_sd, 1e-12);
  DOUBLES_EQUAL(2.0 * std::pow(19.0 / 16.0, 2), *vx.degrees_of_freedom, 1e-12);
  DOUBLES_EQUAL(3.30, *vx.expanded_uncertainty / *vx.total_sd, 0.01);
}

TEST(Series, BudgetNamesTheScatterAndWhatIsShared) {
  const SeriesSummary summary = summarize("", series_shots({10.0, 12.0, 14.0}, -0.5));
  const auto& budget = of(summary, Quantity::vx_td_mps).budget;
  CHECK_EQUAL(2U, budget.size());
  CHECK_EQUAL(std::string("scatter of the shots"), budget[0].source);
  CHECK_TRUE(budget[0].type == EvaluationType::a && !budget[0].shared);
  DOUBLES_EQUAL(2.0, *budget[0].degrees_of_freedom, 0.0);
  CHECK_EQUAL(std::string("scale"), budget[1].source);
  CHECK_TRUE(budget[1].type == EvaluationType::b && budget[1].shared);
  DOUBLES_EQUAL(-0.5, *budget[1].sensitivity, 1e-12);
  DOUBLES_EQUAL(0.5, budget[1].effect, 1e-12);
  DOUBLES_EQUAL(1.0, budget[0].share + budget[1].share, 1e-12);
}

TEST(Series, OfOneShotHasNeitherScatterNorTotal) {
  const SeriesSummary summary = summarize("", series_shots({10.0}, 0.5));
  const QuantitySummary& vx = of(summary, Quantity::vx_td_mps);
  DOUBLES_EQUAL(10.0, vx.mean, 0.0);
  DOUBLES_EQUAL(0.5, vx.shared_sd, 1e-12);
  CHECK_FALSE(vx.scatter_sd || vx.standard_error || vx.total_sd || vx.expanded_uncertainty);
  CHECK_EQUAL(0, of(summary, Quantity::mu).n);
}

TEST(Series, CountsRejectedShotsAndLeavesTheirNumbersOut) {
  auto shots = series_shots({10.0, 12.0, 99.0});
  shots[2].rejected = "no image of the ball";
  const SeriesSummary summary = summarize("", shots);
  CHECK_EQUAL(2, summary.counted);
  CHECK_EQUAL(1, summary.rejected);
  DOUBLES_EQUAL(11.0, of(summary, Quantity::vx_td_mps).mean, 1e-12);
}

// Two calibrations, independent: half of the shots have each, sqrt(0.25^2 + 0.25^2). The same: 0.5.
TEST(Series, AveragesTheErrorsOfDifferentCalibrationsAndNotOfTheSame) {
  auto shots = series_shots({10.0, 12.0, 14.0, 12.0}, 0.5);
  DOUBLES_EQUAL(0.5, of(summarize("", shots), Quantity::vx_td_mps).shared_sd, 1e-12);
  shots[2].calibration = shots[3].calibration = "another camera's";
  const SeriesSummary summary = summarize("", shots);
  DOUBLES_EQUAL(std::sqrt(0.125), of(summary, Quantity::vx_td_mps).shared_sd, 1e-12);
  CHECK_EQUAL(std::string("scale (2)"), of(summary, Quantity::vx_td_mps).budget[2].source);
}

TEST(Series, SharesABallsErrorWithTheSameBallOnly) {
  std::vector<Shot> shots;
  for (int i = 0; i < 4; ++i) shots.push_back(series_shot(std::to_string(i), 10.0, 0.8, 0.5, 0.02));
  DOUBLES_EQUAL(0.02, of(summarize("", shots), Quantity::e).shared_sd, 1e-12);
  for (Shot& shot : shots) shot.ball = shot.name;
  DOUBLES_EQUAL(0.01, of(summarize("", shots), Quantity::e).shared_sd, 1e-12);
  DOUBLES_EQUAL(0.5, of(summarize("", shots), Quantity::vx_td_mps).shared_sd, 1e-12);
}

// A source that pushes some shots up and others down cancels in their mean: topspin and backspin, say.
TEST(Series, AveragesSharedEffectsWithTheirSigns) {
  std::vector<Shot> shots{series_shot("1", 10.0, 0.8, 0.5), series_shot("2", 10.0, 0.8, -0.5)};
  DOUBLES_EQUAL(0.0, of(summarize("", shots), Quantity::vx_td_mps).shared_sd, 1e-12);
}

TEST(Series, HasNoTotalWhereAShotCameWithoutItsBudget) {
  auto shots = series_shots({10.0, 12.0, 14.0}, 0.5);
  shots[1].budget.sources.clear();
  const SeriesSummary summary = summarize("", shots);
  const QuantitySummary& vx = of(summary, Quantity::vx_td_mps);
  CHECK_FALSE(vx.shared_known || vx.total_sd || vx.expanded_uncertainty);
  DOUBLES_EQUAL(2.0, *vx.scatter_sd, 1e-12);
}

TEST(Series, NamesTheShotThatStandsApartAndCountsIt) {
  const SeriesSummary summary =
      summarize("", series_shots({10.0, 10.1, 9.9, 10.05, 9.95, 10.02, 9.98, 14.0, 10.0}));
  CHECK_EQUAL(9, of(summary, Quantity::vx_td_mps).n);
  CHECK_EQUAL(1U, summary.outliers.size());
  CHECK_EQUAL(std::string("8"), summary.outliers[0].shot);
  CHECK_TRUE(summary.outliers[0].quantity == Quantity::vx_td_mps);
  CHECK_TRUE(summary.outliers[0].sds > 30.0);
}

// Grubbs's critical value of 9 at 1 % (two sides) is G = 2.387: the farthest by so many sds of all from the mean of all.
// With eight at ±a and one at x that is reached near x = 5.6 a.
TEST(Series, NamesShotsAtGrubbsCriticalValue) {
  const auto with_last = [](double x) {
    return summarize("", series_shots({1, -1, 1, -1, 1, -1, 1, -1, x})).outliers.size();
  };
  const auto g = [](double x) {
    std::vector<double> v{1, -1, 1, -1, 1, -1, 1, -1, x};
    double mean = x / 9.0, squares = 0.0;
    for (const double each : v) squares += (each - mean) * (each - mean);
    return (x - mean) / std::sqrt(squares / 8.0);
  };
  double x = 1.0;
  while (with_last(x) == 0) x += 0.001;
  DOUBLES_EQUAL(2.387, g(x), 0.001);
}

TEST(Series, DoesNotDependOnTheOrderOfShots) {
  CHECK_TRUE(rc::check([] {
    auto shots = series_shots(some_values(), 0.25);
    const SeriesSummary one = summarize("", shots);
    std::ranges::reverse(shots);
    const SeriesSummary other = summarize("", shots);
    const auto &a = of(one, Quantity::vx_td_mps), &b = of(other, Quantity::vx_td_mps);
    RC_ASSERT(std::abs(a.mean - b.mean) < 1e-12);
    RC_ASSERT(std::abs(*a.total_sd - *b.total_sd) < 1e-12 * (1.0 + *a.total_sd));
    RC_ASSERT(one.outliers.size() == other.outliers.size());
  }));
}

TEST(Series, OfIdenticalShotsHasNoScatterAndTheSharedPartWhateverTheirNumber) {
  CHECK_TRUE(rc::check([] {
    const int n = *rc::gen::inRange(2, 40);
    const auto summary =
        summarize("", series_shots(std::vector<double>(static_cast<std::size_t>(n), 7.25), 0.5));
    const auto& vx = of(summary, Quantity::vx_td_mps);
    RC_ASSERT(*vx.scatter_sd == 0.0);
    RC_ASSERT(std::abs(vx.shared_sd - 0.5) < 1e-12);
    RC_ASSERT(std::abs(*vx.total_sd - 0.5) < 1e-12);
    RC_ASSERT(std::abs(*vx.expanded_uncertainty - 1.959964 * 0.5) < 1e-6);
    RC_ASSERT(summary.outliers.empty());
  }));
}

TEST(Series, TotalIsNeverBelowTheSharedPartOrTheStandardError) {
  CHECK_TRUE(rc::check([] {
    const auto summary = summarize("", series_shots(some_values(), *rc::gen::inRange(-50, 50) / 16.0));
    const auto& vx = of(summary, Quantity::vx_td_mps);
    RC_ASSERT(*vx.total_sd >= vx.shared_sd);
    RC_ASSERT(*vx.total_sd >= *vx.standard_error);
    double shares = 0.0;
    for (const BudgetLine& line : vx.budget) shares += line.share;
    RC_ASSERT(*vx.total_sd == 0.0 || std::abs(shares - 1.0) < 1e-9);
  }));
}

using namespace strobe::host;

TEST_GROUP(IndividualsChart){};

TEST(IndividualsChart, HasLimitsOfThreeSdsByTheMovingRange) {
  // Ranges 2, 1, 3: mean 2, sd 2 / 1.128379 = 1.772454; mean of 10, 12, 11, 14 is 11.75.
  const auto limits = individuals_limits(std::vector<double>{10.0, 12.0, 11.0, 14.0}).value();
  DOUBLES_EQUAL(11.75, limits.mean, 1e-12);
  DOUBLES_EQUAL(11.75 - 5.317362, limits.lower, 1e-5);
  DOUBLES_EQUAL(11.75 + 5.317362, limits.upper, 1e-5);
}

TEST(IndividualsChart, OfFewShotsHasNone) {
  CHECK_FALSE(individuals_limits(std::vector<double>{1.0, 2.0, 3.0}).has_value());
  CHECK_FALSE(individuals_limits({}).has_value());
}

TEST(IndividualsChart, EstimatesTheSdOfNormalNumbersWhateverTheirDrift) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.5);
  std::vector<double> values;
  for (int i = 0; i < 20'000; ++i) values.push_back(noise(random) + 1e-3 * i);
  const auto limits = individuals_limits(values).value();
  // The mean of 20,000 ranges of sd 0.43 scatters by 0.003; three sds by 0.008.
  DOUBLES_EQUAL(1.5, limits.upper - limits.mean, 0.03);
}

// Differences of two series.
using namespace strobe;
using namespace strobe::host;
using namespace strobe::test;
using reduction::Quantity;

namespace {

reduction::Quantities to_find(double vx) {
  reduction::Quantities asked;
  asked[Quantity::vx_td_mps] = vx;
  return asked;
}

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
  for (Shot& shot : second) shot.calibration = "another camera's";
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
  const QuantityDifference d = vx(compare(first, second, to_find(1.0)));
  CHECK_EQUAL(15, d.more_first.value());
  CHECK_EQUAL(15, d.more_second.value());
  CHECK_FALSE(vx(compare(first, second)).more_first.has_value());  // none was found
}

// Of one quantity alone: the other's shots are counted for the difference found, which is 0.
TEST(Comparison, CountsForADifferenceOfTheQuantityThatItIsAskedOf) {
  const auto first = series_of(series_shots({-1.0, 1.0})), second = series_of(series_shots({-1.0, 1.0}));
  const auto comparison = compare(first, second, to_find(1.0));
  CHECK_TRUE(vx(comparison).is_asked);
  CHECK_FALSE(comparison.of(Quantity::e)->is_asked);
  DOUBLES_EQUAL(0.0, comparison.of(Quantity::e)->asked, 0.0);
  // sd sqrt 2, no shared part: 2 * 2 (2.8 / 1e-3)^2, 31 million, is beyond what is counted, but enough would do.
  CHECK_EQUAL(1000000 - 2, vx(compare(first, second, to_find(1e-3))).more_first.value());
}

TEST(Comparison, SaysWhereNoNumberOfShotsWouldDo) {
  auto first = series_shots({-1.0, 1.0}, 0.5), second = series_shots({-1.0, 1.0});
  CHECK_FALSE(
      vx(compare(series_of(first), series_of(second), to_find(1.4))).more_first.has_value());  // 2.80 * 0.5 = 1.4007
  CHECK_TRUE(vx(compare(series_of(first), series_of(second), to_find(1.5))).more_first.has_value());
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
