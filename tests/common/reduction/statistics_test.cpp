// Student's t, court pace and derivatives, against printed tables and worked examples.
#include <cmath>

#include "common/reduction/propagate.hpp"
#include "common/reduction/surface_crossing.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/reduction/running_statistics.hpp"
#include "common/statistics/distributions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;

TEST_GROUP(RunningStatistics){};

TEST(RunningStatistics, AreThoseOfTheThesis) {
  RunningStatistics s;
  for (const double v : {2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0}) s.add(v);
  DOUBLES_EQUAL(5.0, s.mean(), 1e-15);
  DOUBLES_EQUAL(2.0, s.population_sd(), 1e-15);  // squares 9 1 1 1 0 0 4 16 = 32, over 8
}

TEST(RunningStatistics, IdenticalValuesHaveNoSpread) {
  for (const double value : {0.1, 15.62, -1e15, 1e-300, 0.0}) {
    RunningStatistics series;
    for (int i = 0; i < 1000; ++i) series.add(value);
    DOUBLES_EQUAL(value, series.mean(), 0.0);
    DOUBLES_EQUAL(0.0, series.population_sd(), 0.0);
  }
}

TEST(RunningStatistics, ALargeOffsetCostsOnlyItsOwnRounding) {
  // 1, 2, 3 ... 9 on top of 1e9: sd sqrt(60 / 9). The sum of squares less the square of the sum would keep
  // no digit. Values at 1e9 are rounded to 1e-7, here not at all.
  RunningStatistics series;
  for (int i = 1; i <= 9; ++i) series.add(1e9 + i);
  DOUBLES_EQUAL(1e9 + 5, series.mean(), 0.0);
  DOUBLES_EQUAL(std::sqrt(60.0 / 9.0), series.population_sd(), 1e-7);
}

TEST_GROUP(StudentT){};

TEST(StudentT, HoldsAsMuchAsOneSigmaOfANormal) {
  // GUM, table G.2, column 68.27 %: 1.84, 1.32, 1.20, 1.14, 1.11; 1.05 at 10; 1.03 at 20.
  for (const auto& [degrees, factor] :
       {std::pair{1, 1.84}, {2, 1.32}, {3, 1.20}, {5, 1.11}, {10, 1.05}, {20, 1.03}})
    DOUBLES_EQUAL(factor, statistics::student_t_sigma(degrees), 0.005);
  DOUBLES_EQUAL(1.0, statistics::student_t_sigma(1e9), 1e-12);
}

TEST(StudentT, HalfWidthsAreThoseOfTheTables) {
  // GUM, table G.2, column 95 %.
  for (const auto& [degrees, factor] : {std::pair{1, 12.71}, {2, 4.30}, {3, 3.18}, {10, 2.23}})
    DOUBLES_EQUAL(factor, statistics::student_t_half_width(0.95, degrees), 0.005);
  DOUBLES_EQUAL(1.95996, statistics::student_t_half_width(0.95, 1e9), 1e-5);
}

TEST(StudentT, TailsAreThoseOfTheTables) {
  DOUBLES_EQUAL(0.05, statistics::student_t_tail(2.228, 10),
                1e-4);  // the 95 % point of ten degrees of freedom
  DOUBLES_EQUAL(0.3173, statistics::student_t_tail(1.0, 1e9), 1e-4);
}

TEST_GROUP(ExpandedUncertainty) { Readout readout; };

TEST(ExpandedUncertainty, IsTwiceTheSdOfAKnownNoise) {
  readout.sd[Quantity::e] = 0.01;
  DOUBLES_EQUAL(0.0196, *expanded_uncertainty(readout, Quantity::e), 1e-6);
}

TEST(ExpandedUncertainty, IsThatOfStudentsTWhereTheNoiseWasEstimated) {
  // Of two degrees of freedom 68.27 % are within 1.321 of an estimated sd, 95 % within 4.303.
  readout.sd[Quantity::e] = 1.321;
  readout.degrees_of_freedom[Quantity::e] = 2.0;
  DOUBLES_EQUAL(4.303, *expanded_uncertainty(readout, Quantity::e), 2e-3);
}

TEST(ExpandedUncertainty, HoldsWhatTolerancesAdd) {
  readout.sd[Quantity::e] = 0.03;
  readout.sd_systematic[Quantity::e] = 0.04;
  DOUBLES_EQUAL(1.95996 * 0.05, *expanded_uncertainty(readout, Quantity::e), 1e-6);
}

TEST(ExpandedUncertainty, OfANumberWithoutSdIsNone) {
  readout.value[Quantity::e] = 0.7;
  CHECK_FALSE(expanded_uncertainty(readout, Quantity::e).has_value());
}

TEST_GROUP(CourtPace){};

TEST(CourtPace, GivesTheRatingsOfTheWorkedExamples) {
  DOUBLES_EQUAL(37.0, court_pace_rating(0.81, 0.63, 23.0), 1e-9);
  DOUBLES_EQUAL(6.5, court_pace_rating(0.90, 0.80, 23.0), 1e-9);
  DOUBLES_EQUAL(56.0, court_pace_rating(0.75, 0.53, 23.0), 1e-9);
  DOUBLES_EQUAL(37.0 - 150 * 0.03, court_pace_rating(0.81, 0.63, 13.0), 1e-9);
}

TEST(CourtPace, KeepsTheMethodsLimits) {
  CHECK_TRUE(meets_court_pace_limits(31.9, -17.9, 18.8));
  CHECK_FALSE(meets_court_pace_limits(32.1, -16.0, 0.0));
  CHECK_FALSE(meets_court_pace_limits(30.0, -18.1, 0.0));
  CHECK_FALSE(meets_court_pace_limits(30.0, 16.0, 0.0));
  CHECK_FALSE(meets_court_pace_limits(30.0, -16.0, 18.9));
}

TEST_GROUP(Derivatives){};

TEST(Derivatives, AgreeWithDifferencesOfTheValue) {
  const auto formula = [](const Dual<2>& a, const Dual<2>& b) {
    return atan2(sqrt(a * b + 2.0) - b / a, 3.0 - a) * hypot(a, -b) + 0.5 * (a - 1.0) / b;
  };
  const double a = 1.3, b = 0.7, h = 1e-6;
  const auto f = formula(Dual<2>::variable(a, 0), Dual<2>::variable(b, 1));
  // Central differences: rounding 1e-16 / 1e-6 and h^2 leave 1e-9.
  DOUBLES_EQUAL((formula(a + h, b).value - formula(a - h, b).value) / (2 * h), f.grad[0], 1e-8);
  DOUBLES_EQUAL((formula(a, b + h).value - formula(a, b - h).value) / (2 * h), f.grad[1], 1e-8);
}

// d atan2(y, x)/dx = -y/(x² + y²) = -1/(2·size) at x = y = size, whose square no double holds.
TEST(Derivatives, OfTheArctangentHoldBeyondTheSquaresRange) {
  for (const double size : {1e-200, 1.0, 1e200}) {
    const auto angle = atan2(Dual<2>::variable(size, 0), Dual<2>::variable(size, 1));
    DOUBLES_EQUAL(0.5, angle.grad[0] * size, 1e-15);
    DOUBLES_EQUAL(-0.5, angle.grad[1] * size, 1e-15);
  }
}
