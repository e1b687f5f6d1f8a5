// Samplers against densities whose moments are known exactly.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/sampling/adaptive_metropolis.hpp"
#include "common/sampling/importance_sampling.hpp"
#include "common/sampling/sample.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sampling;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Normal of mean (1, -2, 3), sds 1, 10 and 0.1, the first two correlated by 0.99.
struct CorrelatedNormal {
  Eigen::Vector3d mean{1.0, -2.0, 3.0};
  Eigen::Matrix3d covariance{{1.0, 9.9, 0.0}, {9.9, 100.0, 0.0}, {0.0, 0.0, 0.01}};

  sampling::LogDensity density() const {
    const Eigen::Matrix3d precision = covariance.inverse();
    return [centre = mean, precision](const Eigen::VectorXd& x) {
      const Eigen::Vector3d away = x - centre;
      return -0.5 * away.dot(precision * away);
    };
  }
};

/// Haario's banana: x normal of sd 2, y = z + b(x² - 4) with z standard normal. Its means are 0, its variances 4 and 1 +
/// 2·b²·4², its covariance 0.
struct Banana {
  double b = 0.5;
  double variance_y() const { return 1.0 + 32.0 * b * b; }

  sampling::LogDensity density() const {
    return [bend = b](const Eigen::VectorXd& x) {
      const double z = x[1] - bend * (x[0] * x[0] - 4.0);
      return -0.5 * (x[0] * x[0] / 4.0 + z * z);
    };
  }
};

/// Four and a half sds of a mean of so many independent draws: one such check in a hundred thousand fails by chance.
double mean_tolerance(double variance, double effective_size) {
  return 4.5 * std::sqrt(variance / effective_size);
}

}  // namespace

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

namespace {

/// By the inverse of the distribution.
std::vector<double> pareto_numbers(double shape, double scale, int count, std::uint64_t seed) {
  RandomNumbers random(seed);
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(scale * (std::pow(random.uniform(), -shape) - 1.0) / shape);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

TEST_GROUP(ParetoTail){};

// The likelihood's sd of the shape is (1 + k)/sqrt(n), of the scale's logarithm sqrt(2(1 + k)/n); 4.5 of them, and of the
// shape's pull to 1/2 by 10 excesses of 3000 what that makes.
TEST(ParetoTail, FindsTheShapeAndScaleOfATail) {
  constexpr int kCount = 3000;
  for (const double k : {0.1, 0.4, 0.7, 1.2}) {
    const ParetoTail found = fit_pareto_tail(pareto_numbers(k, 3.0, kCount, 17));
    const double pulled = k + (0.5 - k) * 10.0 / (kCount + 10.0);
    DOUBLES_EQUAL(pulled, found.shape, 4.5 * (1.0 + k) / std::sqrt(kCount));
    DOUBLES_EQUAL(std::log(3.0), std::log(found.scale), 4.5 * std::sqrt(2.0 * (1.0 + k) / kCount));
  }
}

// Weights u^-k with u uniform have a Pareto tail of the shape k.
TEST(ParetoTail, WeightsAreSmoothedAndTheirTailIsTold) {
  RandomNumbers random(23);
  VectorXd logs(20000);
  for (double& x : logs) x = -0.9 * std::log(random.uniform());
  const SmoothedWeights smoothed = smoothed_weights(logs);
  // Of the 425 largest; as above.
  DOUBLES_EQUAL(0.9, smoothed.shape, 4.5 * 1.9 / std::sqrt(425.0));
  DOUBLES_EQUAL(1.0, smoothed.weights.sum(), 1e-12);
  // Order is kept, and the largest is less than it was.
  VectorXd raw = (logs.array() - logs.maxCoeff()).exp();
  raw /= raw.sum();
  VectorXd::Index largest = 0;
  raw.maxCoeff(&largest);
  VectorXd::Index still = 0;
  smoothed.weights.maxCoeff(&still);
  LONGS_EQUAL(largest, still);
}

TEST(ParetoTail, AWeightOfZeroStaysOut) {
  VectorXd logs = VectorXd::Zero(1000);
  for (int i = 0; i < 500; ++i) logs[i] = -std::numeric_limits<double>::infinity();
  const SmoothedWeights smoothed = smoothed_weights(logs);
  DOUBLES_EQUAL(0.0, smoothed.weights[3], 0.0);
  DOUBLES_EQUAL(1.0 / 500.0, smoothed.weights[700], 1e-12);
  CHECK_COMPARE(smoothed.shape, <, kMaxParetoShape);
}

TEST(ParetoTail, FewWeightsDoNotTell) {
  CHECK_TRUE(std::isinf(smoothed_weights(VectorXd::LinSpaced(20, 0.0, 1.0)).shape));
}
