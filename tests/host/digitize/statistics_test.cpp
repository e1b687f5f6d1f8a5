#include "host/digitize/core/statistics.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::digitize;

TEST_GROUP(Statistics){};

TEST(Statistics, AQuantileIsTheValueOfItsRank) {
  const std::vector<int> values{5, 1, 4, 2, 3};
  LONGS_EQUAL(4, quantile(values, 3, 4));
  LONGS_EQUAL(4, quantile(values, 7, 10));
  LONGS_EQUAL(3, upper_median(values));
  LONGS_EQUAL(0, quantile(std::vector<int>{}, 3, 4));
}

TEST(Statistics, TheMedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  DOUBLES_EQUAL(2.5, median({4.0, 1.0, 3.0, 2.0}), 0.0);
  DOUBLES_EQUAL(3.0, upper_median(std::vector<double>{4.0, 1.0, 3.0, 2.0}), 0.0);
  DOUBLES_EQUAL(2.0, median({3.0, 1.0, 2.0}), 0.0);
}
