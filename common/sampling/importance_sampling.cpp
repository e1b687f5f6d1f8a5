#include "common/sampling/importance_sampling.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <utility>

#include "common/sampling/pareto_tail.hpp"
#include "common/sampling/random_numbers.hpp"

namespace strobe::sampling {

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
