// The mixture of several hypotheses about one photograph.
#include "common/reduction/mixture.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::reduction;

MixtureComponent component(double e, double sd, double weight) {
  MixtureComponent c;
  c.value[Quantity::e] = e;
  c.sd[Quantity::e] = sd;
  c.sd_systematic[Quantity::e] = 0.002;
  c.regime = Regime::slides;
  c.weight = weight;
  return c;
}

Readout mixed(const std::vector<MixtureComponent>& components) {
  Readout readout;
  readout.value = components.front().value;
  readout.sd = components.front().sd;
  readout.sd_systematic = components.front().sd_systematic;
  readout.regime = components.front().regime;
  mix(components, readout);
  return readout;
}

}  // namespace

TEST_GROUP(Mixture){};

TEST(Mixture, HasTheMeanAndTheTotalVariance) {
  const Readout r =
      mixed({component(0.70, 0.01, 0.5), component(0.72, 0.02, 0.25), component(0.74, 0.03, 0.25)});
  DOUBLES_EQUAL(0.715, *r.value[Quantity::e], 1e-15);
  const double within = 0.5 * 1e-4 + 0.25 * 4e-4 + 0.25 * 9e-4;
  const double between = 0.5 * 225e-6 + 0.25 * 25e-6 + 0.25 * 625e-6;
  DOUBLES_EQUAL(std::sqrt(within + between), *r.sd[Quantity::e], 1e-15);
  DOUBLES_EQUAL(std::sqrt(between), *r.assignments->sd[Quantity::e], 1e-15);
  DOUBLES_EQUAL(0.002, *r.sd_systematic[Quantity::e], 1e-15);
  LONGS_EQUAL(3, r.assignments->hypotheses);
  CHECK_FALSE(r.value[Quantity::mu].has_value());
}

TEST(Mixture, OfOneHypothesisIsItsReadout) {
  const Readout r = mixed({component(0.7, 0.01, 1.0)});
  DOUBLES_EQUAL(0.7, *r.value[Quantity::e], 0.0);
  DOUBLES_EQUAL(0.01, *r.sd[Quantity::e], 1e-17);
  DOUBLES_EQUAL(0.0, *r.assignments->sd[Quantity::e], 0.0);
}

TEST(Mixture, IsAmbiguousWhereTwoEquallyLikelyOnesHaveTwoPeaks) {
  // Two normal densities a distance d apart have two peaks from d = 2 sd on.
  CHECK_FALSE(mixed({component(0.70, 0.01, 1.0), component(0.7199, 0.01, 1.0)})
                  .flags.has(Flag::flash_match_ambiguous));
  CHECK_TRUE(mixed({component(0.70, 0.01, 1.0), component(0.7201, 0.01, 1.0)})
                 .flags.has(Flag::flash_match_ambiguous));
}

TEST(Mixture, CountsAHypothesisOnlyForTheNumbersThatItHas) {
  MixtureComponent without = component(0.8, 0.01, 3.0);
  without.value[Quantity::e].reset();
  DOUBLES_EQUAL(0.7, *mixed({component(0.7, 0.01, 1.0), without}).value[Quantity::e], 1e-15);
}

TEST(Mixture, LeavesARegimeOpenThatMoreThanOneInTwentyContradicts) {
  MixtureComponent grips = component(0.7, 0.01, 0.04);
  grips.regime = Regime::grips;
  CHECK_TRUE(mixed({component(0.7, 0.01, 0.96), grips}).regime == Regime::slides);
  grips.weight = 0.07;
  CHECK_TRUE(mixed({component(0.7, 0.01, 0.93), grips}).regime == Regime::unclear);
}

TEST(Mixture, KnowsMoreDegreesOfFreedomTheMoreOfItsVarianceIsBetweenTheHypotheses) {
  MixtureComponent a = component(0.70, 0.01, 1.0), b = component(0.72, 0.01, 1.0);
  Readout r;
  r.value = a.value;
  r.sd = a.sd;
  r.degrees_of_freedom[Quantity::e] = 3.0;
  mix(std::vector{a, b}, r);
  // Half of the variance has three, the other half infinitely many: 1 / (0.5^2 / 3).
  DOUBLES_EQUAL(12.0, *r.degrees_of_freedom[Quantity::e], 1e-9);
}
