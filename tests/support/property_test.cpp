#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/property.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::testing;

TEST_GROUP(Property) {
  TemporaryFolder folder;
  std::string file = folder.path() / "properties.tsv";

  void setup() override { setenv("STROBE_PROPERTIES", file.c_str(), 1); }
  void teardown() override { unsetenv("STROBE_PROPERTIES"); }

  std::string recorded() const {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

// 0.4 of 1 is nearer to its tolerance than 3 of 30.
TEST(Property, RecordsTheDeviationThatIsWorstForItsTolerance) {
  int draw = 0;
  CHECK(holds_of_all([&](Worst& worst) {
    RC_ASSERT(worst.within(3.0, 30.0));
    RC_ASSERT(worst.within(++draw == 7 ? 0.4 : 0.01, 1.0));
  }));
  CHECK_EQUAL("Property.RecordsTheDeviationThatIsWorstForItsTolerance\t" + std::to_string(draw) + "\t0.4\t1\tholds\n",
              recorded());
}

TEST(Property, WithoutNumbersRecordsItsDraws) {
  int draws = 0;
  CHECK(holds_of_all([&] { ++draws; }));
  CHECK_EQUAL("Property.WithoutNumbersRecordsItsDraws\t" + std::to_string(draws) + "\t-\t-\tholds\n", recorded());
}

TEST(Property, NotANumberIsNotWithinAnyTolerance) {
  Worst worst;
  CHECK_FALSE(worst.within(std::nan(""), 1.0));
  CHECK(worst.within(0.0, 0.0));
  CHECK_FALSE(worst.within(1e-300, 0.0));
}

// Of a generator that grows with the draws the first hundred would all be small.
TEST(Property, DrawsReachBothEndsOfTheirRangeFromTheFirstOn) {
  int first_quarter = 0, last_quarter = 0, draws = 0;
  CHECK(holds_of_all([&] {
    const double x = over_decades(1e-8, 1.0);
    RC_ASSERT(x >= 1e-8 && x <= 1.0);
    if (++draws > 40) return;
    first_quarter += x < 1e-6;
    last_quarter += x > 1e-2;
  }));
  // Each is binomial, 10 of 40 expected, sd 2.7: none is 0 but once in 1e5 runs.
  CHECK(first_quarter > 0);
  CHECK(last_quarter > 0);
}
