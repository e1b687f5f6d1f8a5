#include "common/sampling/pareto_tail.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/sampling/random_numbers.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sampling;
using Eigen::VectorXd;

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
