#include "sim/random/draws.hpp"

#include <cmath>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

TEST_GROUP(Draws){};

TEST(Draws, RepeatForTheSameSeedPurposeAndShot) {
  Draws a(7, Purpose::tablet, 3);
  Draws b(7, Purpose::tablet, 3);
  for (int i = 0; i < 100; ++i) DOUBLES_EQUAL(a.normal(), b.normal(), 0.0);
}

TEST(Draws, DifferWithSeedPurposeOrShot) {
  const double here = Draws(7, Purpose::tablet, 3).uniform();
  CHECK(here != Draws(8, Purpose::tablet, 3).uniform());
  CHECK(here != Draws(7, Purpose::bounce, 3).uniform());
  CHECK(here != Draws(7, Purpose::tablet, 4).uniform());
}

TEST(Draws, StayWithinTheOpenUnitInterval) {
  Draws draws(1, Purpose::machine, 1);
  for (int i = 0; i < 100000; ++i) {
    const double u = draws.uniform();
    CHECK(u > 0.0 && u < 1.0);
  }
}

TEST(Draws, AreNormalAndIndependentAcrossShots) {
  // First draws of 200,000 neighbouring streams: what a shot-by-shot spread is made of. Standard errors are
  // 1/sqrt(n) for the mean and the lag-one correlation, sqrt(2/n) for the variance, sqrt(24/n) for the excess
  // kurtosis; five of them.
  constexpr int n = 200000;
  std::vector<double> x;
  for (int shot = 1; shot <= n; ++shot)
    x.push_back(Draws(42, Purpose::bounce, static_cast<std::uint64_t>(shot)).normal());
  double mean = 0.0, square = 0.0, fourth = 0.0, lag = 0.0;
  for (int i = 0; i < n; ++i) {
    const double v = x[static_cast<std::size_t>(i)];
    mean += v / n;
    square += v * v / n;
    fourth += v * v * v * v / n;
    if (i > 0) lag += v * x[static_cast<std::size_t>(i - 1)] / n;
  }
  DOUBLES_EQUAL(0.0, mean, 5.0 / std::sqrt(n));
  DOUBLES_EQUAL(1.0, square, 5.0 * std::sqrt(2.0 / n));
  DOUBLES_EQUAL(3.0, fourth, 5.0 * std::sqrt(96.0 / n));
  DOUBLES_EQUAL(0.0, lag, 5.0 / std::sqrt(n));
}

TEST(Draws, AreTheSameOnEveryMachine) {
  // Computed apart, in integer arithmetic, from SplitMix64's definition: what a printed seed once meant stays
  // so.
  Draws draws(1, Purpose::machine, 1);
  DOUBLES_EQUAL(0.48216638688022645, draws.uniform(), 1e-16);
  DOUBLES_EQUAL(0.18470926541650973, draws.uniform(), 1e-16);
  DOUBLES_EQUAL(0.8106642580215659, draws.uniform(), 1e-16);
}

TEST(Draws, TakeANormalWithoutSpreadAsIfItHadOne) {
  Draws with(1, Purpose::machine, 1);
  Draws without(1, Purpose::machine, 1);
  with.normal(3.0, 0.5);
  DOUBLES_EQUAL(3.0, without.normal(3.0, 0.0), 0.0);
  DOUBLES_EQUAL(with.uniform(), without.uniform(), 0.0);
}
