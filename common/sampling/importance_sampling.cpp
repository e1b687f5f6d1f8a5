#include "common/sampling/importance_sampling.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/sampling/sample.hpp"

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
  assert(out.weights.minCoeff() >= 0.0);
  return out;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A proposal that is too narrow is worse than one that is too wide.
constexpr double kWider = 1.2;

struct Proposal {
  VectorXd centre;
  MatrixXd root;
  int degrees_of_freedom;

  Proposal(VectorXd at, const MatrixXd& covariance, int degrees)
      : centre(std::move(at)), root(covariance.llt().matrixL()), degrees_of_freedom(degrees) {}

  /// A point of the t distribution, and the logarithm of its density up to a constant.
  std::pair<VectorXd, double> draw(RandomNumbers& random) const {
    const VectorXd z = random.normals(centre.size());
    const double nu = degrees_of_freedom;
    const double stretch = std::sqrt(nu / random.chi_squared(degrees_of_freedom));
    const double dimensions = static_cast<double>(centre.size());
    return {centre + stretch * (root * z),
            -0.5 * (nu + dimensions) * std::log1p(stretch * stretch * z.squaredNorm() / nu)};
  }
};

ImportanceSample draw_round(const LogDensity& density, const Proposal& proposal, int draws,
                            RandomNumbers& random, const std::function<void(int)>& drawn) {
  ImportanceSample out;
  out.sample.points.resize(proposal.centre.size(), draws);
  VectorXd logs(draws);
  for (int i = 0; i < draws; ++i) {
    const auto [point, log_proposal] = proposal.draw(random);
    const double log_density = density(point);
    out.sample.points.col(i) = point;
    logs[i] =
        std::isfinite(log_density) ? log_density - log_proposal : -std::numeric_limits<double>::infinity();
    drawn(i);
  }
  if (!std::isfinite(logs.maxCoeff())) {
    out.sample.weights = VectorXd::Constant(draws, 1.0 / draws);
    out.pareto_shape = std::numeric_limits<double>::infinity();
    return out;
  }
  SmoothedWeights smoothed = smoothed_weights(logs);
  out.sample.weights = std::move(smoothed.weights);
  out.pareto_shape = smoothed.shape;
  return out;
}

}  // namespace

bool ImportanceSample::good(double least_size) const {
  return pareto_shape <= kMaxParetoShape && sample.effective_size() >= least_size;
}

ImportanceSample importance_sample(const LogDensity& density, const VectorXd& centre,
                                   const MatrixXd& covariance, const ImportanceOptions& options) {
  RandomNumbers random(options.seed);
  Proposal proposal(centre, covariance, options.degrees_of_freedom);
  ImportanceSample best;
  for (int round = 1; round <= options.rounds; ++round) {
    ImportanceSample now = draw_round(density, proposal, options.draws, random, [&](int i) {
      if (options.progress) options.progress(static_cast<double>(i) / options.draws);
    });
    const bool good = now.good(options.least_size);
    const bool better = round == 1 || good || now.sample.effective_size() > best.sample.effective_size();
    if (better) best = std::move(now);
    best.rounds = round;
    best.evaluations = round * options.draws;
    if (good) break;
    const MatrixXd next = kWider * best.sample.covariance();
    if (next.llt().info() != Eigen::Success) break;
    proposal = Proposal(best.sample.mean(), next, options.degrees_of_freedom);
  }
  return best;
}

}  // namespace strobe::sampling
