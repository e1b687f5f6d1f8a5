#include "common/sampling/importance_sampling.hpp"

#include <limits>

#include "common/sampling/pareto_tail.hpp"
#include "tests/common/sampling/known_densities.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sampling;
using namespace strobe::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_GROUP(ImportanceSampling){};

TEST(ImportanceSampling, FindsMomentsAndQuantilesOfAStronglyCorrelatedNormalDensity) {
  const CorrelatedNormal truth;
  const auto drawn = importance_sample(truth.density(), truth.mean, truth.covariance, {.draws = 20000});
  LONGS_EQUAL(1, drawn.rounds);
  CHECK_COMPARE(drawn.pareto_shape, <, 0.3);
  const double size = drawn.sample.effective_size();
  CHECK_COMPARE(size, >, 10000.0);
  const MatrixXd covariance = drawn.sample.covariance();
  for (int k = 0; k < 3; ++k) {
    const double variance = truth.covariance(k, k);
    DOUBLES_EQUAL(truth.mean[k], drawn.sample.mean()[k], mean_tolerance(variance, size));
    // The tails, of which the square is made, have smaller weights than the middle: worth half as many draws.
    DOUBLES_EQUAL(variance, covariance(k, k), mean_tolerance(2.0 * variance * variance, 0.5 * size));
    // A quantile's variance: p(1 - p) over the squared density, .0584/sd at 2.5 %.
    const double sd = std::sqrt(0.025 * 0.975 / size) / 0.0584 * std::sqrt(variance);
    const auto ends = drawn.sample.quantiles(k, {0.025, 0.975});
    DOUBLES_EQUAL(truth.mean[k] - 1.96 * std::sqrt(variance), ends[0], 4.5 * sd);
    DOUBLES_EQUAL(truth.mean[k] + 1.96 * std::sqrt(variance), ends[1], 4.5 * sd);
  }
}

// The proposal starts two sds away, with half of the sds and without the correlation.
TEST(ImportanceSampling, AdaptsAProposalThatDoesNotMatch) {
  const CorrelatedNormal truth;
  const VectorXd start = truth.mean + 2.0 * VectorXd(truth.covariance.diagonal().cwiseSqrt());
  const MatrixXd narrow = 0.25 * MatrixXd(truth.covariance.diagonal().asDiagonal());
  const auto drawn =
      importance_sample(truth.density(), start, narrow, {.draws = 5000, .rounds = 8, .least_size = 2000.0});
  CHECK_COMPARE(drawn.rounds, >, 1);
  CHECK_TRUE(drawn.good(2000.0));
  for (int k = 0; k < 3; ++k)
    DOUBLES_EQUAL(truth.mean[k], drawn.sample.mean()[k],
                  mean_tolerance(truth.covariance(k, k), drawn.sample.effective_size()));
}

// A banana with arms of twenty sds of the proposal's second axis is no density for a t distribution.
TEST(ImportanceSampling, TellsThatItCannotBeTrusted) {
  const Banana truth{.b = 10.0};
  const auto drawn = importance_sample(truth.density(), VectorXd::Zero(2), 0.01 * MatrixXd::Identity(2, 2),
                                       {.draws = 2000, .rounds = 1});
  CHECK_FALSE(drawn.good(200.0));
}

TEST(ImportanceSampling, ADensityThatIsNowhereGivesNoTrust) {
  const auto nowhere = [](const VectorXd&) { return -std::numeric_limits<double>::infinity(); };
  const auto drawn = importance_sample(nowhere, VectorXd::Zero(2), MatrixXd::Identity(2, 2), {.draws = 100});
  CHECK_FALSE(drawn.good(10.0));
}
