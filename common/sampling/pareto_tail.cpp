#include "common/sampling/pareto_tail.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace strobe::sampling {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kMinExcesses = 5;
constexpr double kPriorExcesses = 10.0;

double mean_log1p(double factor, const std::vector<double>& values) {
  double sum = 0.0;
  for (const double x : values) sum += std::log1p(factor * x);
  return sum / static_cast<double>(values.size());
}

}  // namespace

ParetoTail fit_pareto_tail(const std::vector<double>& excesses) {
  const std::size_t n = excesses.size();
  const auto grid = 30 + static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
  const double quarter = excesses[static_cast<std::size_t>(static_cast<double>(n) / 4.0 + 0.5) - 1];
  std::vector<double> thetas(grid), logs(grid);
  for (std::size_t j = 0; j < grid; ++j) {
    const double root = std::sqrt(static_cast<double>(grid) / (static_cast<double>(j) + 0.5));
    thetas[j] = 1.0 / excesses.back() + (1.0 - root) / (3.0 * quarter);
    const double k = mean_log1p(-thetas[j], excesses);
    logs[j] = static_cast<double>(n) * (std::log(-thetas[j] / k) - k - 1.0);
  }
  double theta = 0.0, sum = 0.0;
  const double largest = *std::max_element(logs.begin(), logs.end());
  for (std::size_t j = 0; j < grid; ++j) {
    const double weight = std::exp(logs[j] - largest);
    theta += weight * thetas[j];
    sum += weight;
  }
  theta /= sum;
  const double k = mean_log1p(-theta, excesses);
  const auto count = static_cast<double>(n);
  return {(k * count + 0.5 * kPriorExcesses) / (count + kPriorExcesses), -k / theta};
}

SmoothedWeights smoothed_weights(const VectorXd& log_weights) {
  const Index count = log_weights.size();
  const double largest = log_weights.maxCoeff();
  SmoothedWeights out{log_weights.unaryExpr([&](double log) { return std::exp(log - largest); }),
                      std::numeric_limits<double>::infinity()};
  const double share = 0.2 * static_cast<double>(count);
  const auto tail =
      static_cast<std::size_t>(std::ceil(std::min(share, 3.0 * std::sqrt(static_cast<double>(count)))));
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return out.weights[a] < out.weights[b]; });
  if (tail >= kMinExcesses) {
    const std::size_t first = order.size() - tail;
    const double threshold = out.weights[order[first - 1]];
    std::vector<double> excesses;
    for (std::size_t i = first; i < order.size(); ++i) excesses.push_back(out.weights[order[i]] - threshold);
    if (excesses.front() > 0.0 && excesses.back() > excesses.front()) {
      const ParetoTail pareto = fit_pareto_tail(excesses);
      out.shape = pareto.shape;
      for (std::size_t i = 0; i < tail; ++i) {
        const double level = (static_cast<double>(i) + 0.5) / static_cast<double>(tail);
        const double excess =
            std::abs(pareto.shape) < 1e-12
                ? -pareto.scale * std::log1p(-level)
                : pareto.scale * std::expm1(-pareto.shape * std::log1p(-level)) / pareto.shape;
        out.weights[order[first + i]] = std::min(1.0, threshold + excess);
      }
    } else if (excesses.back() <= 0.0) {
      out.shape = -std::numeric_limits<double>::infinity();  // all alike: the proposal is the density
    }
  }
  out.weights /= out.weights.sum();
  return out;
}

}  // namespace strobe::sampling
