#include "common/sampling/adaptive_metropolis.hpp"

#include <algorithm>
#include <random>

#include "tests/common/sampling/known_densities.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sampling;
using namespace strobe::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_GROUP(AdaptiveMetropolis){};

// The first steps are those of a sphere, a hundred times too long in one direction and ten times too short in another. The
// square of a normal number has the variance 2·sd⁴; its draws are worth fewer than the mean's, at worst half of them here.
TEST(AdaptiveMetropolis, FindsMomentsOfAStronglyCorrelatedNormalDensity) {
  const CorrelatedNormal truth;
  const auto drawn = adaptive_metropolis(truth.density(), VectorXd::Zero(3), MatrixXd::Identity(3, 3),
                                         {.seed = 5, .steps = 30000});
  const VectorXd mean = drawn.sample.mean();
  const MatrixXd covariance = drawn.sample.covariance();
  for (int k = 0; k < 3; ++k) {
    const double variance = truth.covariance(k, k), size = drawn.effective_size[k];
    CHECK_COMPARE(size, >, 1000.0);
    CHECK_COMPARE(drawn.r_hat[k], <, 1.02);
    DOUBLES_EQUAL(truth.mean[k], mean[k], mean_tolerance(variance, size));
    DOUBLES_EQUAL(variance, covariance(k, k), mean_tolerance(2.0 * variance * variance, 0.5 * size));
  }
  DOUBLES_EQUAL(0.99, covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)), 0.005);
}

TEST(AdaptiveMetropolis, FindsMomentsOfABanana) {
  const Banana truth;
  const auto drawn = adaptive_metropolis(truth.density(), VectorXd::Zero(2), MatrixXd::Identity(2, 2),
                                         {.seed = 7, .steps = 60000});
  const VectorXd mean = drawn.sample.mean();
  const double variances[] = {4.0, truth.variance_y()};
  for (int k = 0; k < 2; ++k) {
    CHECK_COMPARE(drawn.effective_size[k], >, 1000.0);
    DOUBLES_EQUAL(0.0, mean[k], mean_tolerance(variances[k], drawn.effective_size[k]));
  }
  const auto quartiles = drawn.sample.quantiles(0, {0.25, 0.5, 0.75});
  // A quantile's variance: p(1 - p) over the squared density there, 0.159 at the quartiles of an sd of 2.
  const double sd = std::sqrt(0.25 * 0.75 / (0.159 * 0.159) / drawn.effective_size[0]);
  DOUBLES_EQUAL(-1.349, quartiles[0], 4.5 * sd);
  DOUBLES_EQUAL(0.0, quartiles[1], 4.5 * sd);
  DOUBLES_EQUAL(1.349, quartiles[2], 4.5 * sd);
}

TEST(AdaptiveMetropolis, ASeedGivesTheSameDraws) {
  const auto density = CorrelatedNormal().density();
  const MetropolisOptions options{.seed = 3, .steps = 300};
  const auto one = adaptive_metropolis(density, VectorXd::Zero(3), MatrixXd::Identity(3, 3), options);
  const auto two = adaptive_metropolis(density, VectorXd::Zero(3), MatrixXd::Identity(3, 3), options);
  CHECK_TRUE(one.sample.points == two.sample.points);
  const auto other =
      adaptive_metropolis(density, VectorXd::Zero(3), MatrixXd::Identity(3, 3), {.seed = 4, .steps = 300});
  CHECK_FALSE(one.sample.points == other.sample.points);
}

// An autoregressive chain of coefficient 0.8 has the autocorrelation time (1 + .8)/(1 - .8) = 9.
TEST(AdaptiveMetropolis, TellsHowManyIndependentDrawsAChainIsWorth) {
  std::mt19937_64 source(1);
  std::normal_distribution<double> normal;
  MatrixXd chains(4, 20000);
  for (int c = 0; c < 4; ++c) {
    double x = normal(source) / 0.6;
    for (int i = 0; i < 20000; ++i) chains(c, i) = x = 0.8 * x + normal(source);
  }
  DOUBLES_EQUAL(80000.0 / 9.0, effective_size(chains), 0.1 * 80000.0 / 9.0);
  DOUBLES_EQUAL(1.0, split_r_hat(chains), 0.005);
  chains.row(0).array() += 5.0;
  CHECK_COMPARE(split_r_hat(chains), >, 1.2);
  CHECK_COMPARE(effective_size(chains), <, 100.0);
}

// Every draw a new one, of 4 times 4000 independent ones.
TEST(AdaptiveMetropolis, IndependentDrawsAreWorthTheirNumber) {
  std::mt19937_64 source(2);
  std::normal_distribution<double> normal;
  MatrixXd chains(4, 4000);
  for (double& x : chains.reshaped()) x = normal(source);
  DOUBLES_EQUAL(16000.0, effective_size(chains), 1600.0);
}
