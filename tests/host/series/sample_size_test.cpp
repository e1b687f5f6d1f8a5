// How many shots for a mean's interval, and to find a difference.
#include "host/series/sample_size.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <rapidcheck.h>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;

namespace {

constexpr double kAnyNumber = std::numeric_limits<double>::infinity();

double scatter_of(int n, double sd, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0.0, sd);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < n; ++i) {
    const double value = normal(random);
    sum += value;
    squares += value * value;
  }
  return std::sqrt((squares - sum * sum / n) / (n - 1));
}

}  // namespace

TEST_GROUP(SampleSize){};

// Student's t of 4 degrees of freedom is 2.776445; of 5 normal numbers the mean sd is c4 = 0.939986 of the true one
// (ASTM manual on control charts, Table 49). The quadrature is good to 0.1 % there.
TEST(SampleSize, ExpectsTheHalfWidthThatSeriesHaveInTheMean) {
  DOUBLES_EQUAL(2.776445 * 2.0 / std::sqrt(5.0), mean_half_width(2.0, 0.0, 5), 1e-5);
  const double expected = 0.939986 * 2.776445 * 2.0 / std::sqrt(5.0);
  DOUBLES_EQUAL(expected, expected_half_width(2.0, 0.0, 5), 1e-3 * expected);
}

// What is shared has infinitely many degrees of freedom, and its normal interval alone is 1.959964 wide.
TEST(SampleSize, NeverFallsBelowWhatShotsShare) {
  DOUBLES_EQUAL(1.959964 * 0.5, mean_half_width(0.0, 0.5, 2), 1e-6);
  DOUBLES_EQUAL(1.959964 * 0.5, mean_half_width(1.0, 0.5, kMaxShots), 1e-5);
  CHECK_FALSE(shots_for_mean({1.0}, 0.5, 0.979).has_value());
  CHECK_TRUE(shots_for_mean({1.0}, 0.5, 0.981).has_value());
}

// Of 4,000 series the mean half width scatters by 0.2 %, so that one shot either way shows below 40 shots; the share
// that keeps the assured one scatters by 0.5 %.
TEST(SampleSize, SeriesOfSoManyShotsHaveTheWantedHalfWidthInTheMeanOrAsAssured) {
  std::mt19937_64 random(1);
  constexpr int kSeries = 4000;
  for (const double shared : {0.0, 0.1}) {
    for (const double wanted : {0.4, 1.2}) {
      const int n = shots_for_mean({1.0}, shared, wanted)->shots;
      const int assured = shots_for_mean({1.0}, shared, wanted, 0.9)->shots;
      double sum = 0.0, sum_of_fewer = 0.0;
      int kept = 0, kept_by_fewer = 0;
      for (int i = 0; i < kSeries; ++i) {
        sum += mean_half_width(scatter_of(n, 1.0, random), shared, n);
        sum_of_fewer += mean_half_width(scatter_of(n - 1, 1.0, random), shared, n - 1);
        kept += mean_half_width(scatter_of(assured, 1.0, random), shared, assured) <= wanted ? 1 : 0;
        kept_by_fewer +=
            mean_half_width(scatter_of(assured - 1, 1.0, random), shared, assured - 1) <= wanted ? 1 : 0;
      }
      CHECK_TRUE(sum / kSeries < 1.006 * wanted);
      CHECK_TRUE(sum_of_fewer / kSeries > 0.994 * wanted);
      CHECK_TRUE(kept > (0.9 - 0.015) * kSeries);
      CHECK_TRUE(kept_by_fewer < (0.9 + 0.015) * kSeries);
    }
  }
}

// R 4.2, power.t.test(n = 20, delta = 1, sd = 1): 0.8689528; power.t.test(power = .90, delta = 1): n = 22.02110, and
// of .80 16.71477. Its power leaves out the tail on the other side, 1.2e-6 at most here.
TEST(SampleSize, PowerIsThatOfTheNoncentralT) {
  const TwoMeans means{1.0, 1.0, 0.0};
  DOUBLES_EQUAL(0.8689528, means.power(1.0, 20.0, 20.0), 2e-6);
  DOUBLES_EQUAL(0.90, means.power(1.0, 22.02110, 22.02110), 2e-6);
  DOUBLES_EQUAL(0.80, means.power(1.0, 16.71477, 16.71477), 2e-6);
  CHECK_EQUAL(23, shots_for_difference({{1.0}, {1.0}}, 1.0, 0.9)->shots);
  CHECK_EQUAL(17, shots_for_difference({{1.0}, {1.0}}, 1.0)->shots);
}

TEST(SampleSize, WithoutADifferencePowerIsTheLevel) {
  CHECK_TRUE(rc::check([] {
    const TwoMeans means{*rc::gen::inRange(1, 100) / 10.0, *rc::gen::inRange(1, 100) / 10.0,
                         *rc::gen::inRange(0, 100) / 100.0};
    RC_ASSERT(std::abs(means.power(0.0, *rc::gen::inRange(2, 50), *rc::gen::inRange(2, 50)) - 0.05) < 1e-9);
  }));
}

// However large: small numbers of degrees of freedom and shifts far beyond those that matter.
TEST(SampleSize, PowerRisesWithTheDifferenceAndWithShots) {
  CHECK_TRUE(rc::check([] {
    const TwoMeans means{*rc::gen::inRange(1, 100) / 10.0, *rc::gen::inRange(1, 100) / 10.0,
                         *rc::gen::inRange(0, 100) / 1000.0};
    const double n1 = *rc::gen::inRange(2, 50), n2 = *rc::gen::inRange(2, 50);
    double before = 0.05 - 1e-9;
    for (double difference = 0.01; difference < 1e6; difference *= 1.5) {
      const double power = means.power(difference, n1, n2);
      RC_ASSERT(power >= before - 1e-4);  // where the shift of 50 begins: 2 % of it, of a power near 1
      RC_ASSERT(power <= 1.0 + 1e-12);
      before = power;
    }
  }));
}

// Normal quantiles 1.959964 + 0.841621 = 2.801585, times 0.5.
TEST(SampleSize, SaysWhereNoNumberOfShotsFindsADifference) {
  const TwoSeries series{{1.0}, {1.0}, 0.5};
  CHECK_FALSE(shots_for_difference(series, 1.4007).has_value());
  CHECK_TRUE(shots_for_difference(series, 1.4009).has_value());
  CHECK_FALSE(shots_for_difference(series, 0.0).has_value());
  CHECK_EQUAL(kMaxShots, shots_for_difference({{1.0}, {1.0}}, 1e-3)->shots);
  DOUBLES_EQUAL(1.0, TwoMeans{}.power(1.0, kAnyNumber, kAnyNumber), 0.0);
}

TEST(SampleSize, CountsShotsThatThereAre) {
  CHECK_EQUAL(17, shots_for_difference({{1.0}, {1.0}, 0.0, 5, 9}, 1.0)->shots);
  // With 1,000 of the other it needs 1 / n = 1 / 2.95^2: nine, as Student's t of 8 degrees of freedom is wider.
  const int few = shots_for_difference({{1.0}, {1.0}, 0.0, 2, 1000}, 1.0)->shots;
  CHECK_TRUE(few >= 9 && few <= 11);
}

// sd of 4 degrees of freedom: chi-squared 0.484419 and 11.143287, so that the true one is 0.599 to 2.874 of it; shots
// go about with its square.
TEST(SampleSize, OfAMeasuredScatterIsAsUncertainAsThat) {
  const ShotCount known = *shots_for_mean({1.0}, 0.0, 0.3), measured = *shots_for_mean({1.0, 4.0}, 0.0, 0.3);
  CHECK_EQUAL(known.shots, known.fewest);
  CHECK_EQUAL(known.shots, known.most);
  CHECK_EQUAL(known.shots, measured.shots);
  CHECK_EQUAL(shots_for_mean({std::sqrt(4.0 / 11.143287)}, 0.0, 0.3)->shots, measured.fewest);
  CHECK_EQUAL(shots_for_mean({std::sqrt(4.0 / 0.484419)}, 0.0, 0.3)->shots, measured.most);
  const ShotCount each = *shots_for_difference({{1.0, 4.0}, {1.0, 4.0}}, 1.0);
  CHECK_TRUE(each.fewest < 17 && each.shots == 17 && each.most > 17);
}
