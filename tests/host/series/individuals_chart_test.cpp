#include "host/series/individuals_chart.hpp"

#include <random>
#include <vector>

#include "tests/support/string_from.hpp"

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
