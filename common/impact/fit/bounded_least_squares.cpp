#include "common/impact/fit/bounded_least_squares.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxIterations = 200;
/// Of steps along the axes: measured fits take 26 to 234. Along a narrow valley they would crawl for minutes.
constexpr int kMaxRounds = 1000;
constexpr double kMaxDamping = 1e16;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

VectorXd clamped(const LeastSquaresProblem& problem, const VectorXd& at) {
  return at.cwiseMax(problem.lower).cwiseMin(problem.upper);
}

VectorXd moved(const VectorXd& at, Index i, double step) {
  VectorXd out = at;
  out[i] += step;
  return out;
}

VectorXd derivative(const LeastSquaresProblem& problem, const VectorXd& at, Index i) {
  const double step = problem.difference_step * std::max(std::abs(at[i]), problem.scale[i]);
  const double h = std::min(step, 0.25 * (problem.upper[i] - problem.lower[i]));
  const bool low = at[i] - h < problem.lower[i];
  if (!low && at[i] + h <= problem.upper[i])
    return (problem.residuals(moved(at, i, h)) - problem.residuals(moved(at, i, -h))) / (2.0 * h);
  const double side = low ? h : -h;
  return (4.0 * problem.residuals(moved(at, i, side)) - problem.residuals(moved(at, i, 2.0 * side)) -
          3.0 * problem.residuals(at)) /
         (2.0 * side);
}

/// Free parameters: those not at a bound with the descent direction pointing out of it.
std::vector<Index> free_parameters(const LeastSquaresProblem& problem, const VectorXd& at,
                                   const VectorXd& gradient) {
  std::vector<Index> out;
  for (Index i = 0; i < at.size(); ++i) {
    const bool active = (at[i] <= problem.lower[i] && gradient[i] >= 0.0) ||
                        (at[i] >= problem.upper[i] && gradient[i] <= 0.0);
    if (!active) out.push_back(i);
  }
  return out;
}

/// Minimizes |J·p + r|² + damping·|D·p|² over the free parameters, D being the columns' lengths.
VectorXd damped_step(const MatrixXd& jac, const VectorXd& r, const std::vector<Index>& free, double damping) {
  const auto n = static_cast<Index>(free.size());
  MatrixXd stacked = MatrixXd::Zero(jac.rows() + n, n);
  VectorXd right = VectorXd::Zero(jac.rows() + n);
  right.head(jac.rows()) = -r;
  for (Index k = 0; k < n; ++k) {
    const auto column = jac.col(free[static_cast<std::size_t>(k)]);
    const double length = column.norm();
    stacked.col(k).head(jac.rows()) = column;
    stacked(jac.rows() + k, k) = std::sqrt(damping) * (length > 0.0 ? length : 1.0);
  }
  const VectorXd solution = stacked.colPivHouseholderQr().solve(right);
  VectorXd step = VectorXd::Zero(jac.cols());
  for (Index k = 0; k < n; ++k) step[free[static_cast<std::size_t>(k)]] = solution[k];
  return step;
}

/// Takes one step. Returns why it is the last, if it is.
std::optional<Termination> improve(const LeastSquaresProblem& problem, LeastSquaresResult& now,
                                   double& damping) {
  const VectorXd r = problem.residuals(now.parameters);
  const MatrixXd jac = jacobian(problem, now.parameters);
  const std::vector<Index> free = free_parameters(problem, now.parameters, jac.transpose() * r);
  if (free.empty()) return Termination::no_free_parameter;
  const double predicted_gain = problem.function_tolerance * now.sum_of_squares;
  const double min_gain = std::max(problem.function_tolerance, 4.0 * kEpsilon) * now.sum_of_squares;
  for (; damping <= kMaxDamping; damping *= 8.0) {
    const VectorXd step = damped_step(jac, r, free, damping);
    const VectorXd next = clamped(problem, now.parameters + step);
    const double sum = problem.residuals(next).squaredNorm();
    if (!(sum < now.sum_of_squares)) {
      // With more damping the predicted gain is smaller still.
      const VectorXd change = jac * step;
      if (-change.dot(2.0 * r + change) <= predicted_gain) return Termination::tolerance;
      continue;
    }
    const double gain = now.sum_of_squares - sum;
    now.parameters = next;
    now.sum_of_squares = sum;
    damping = std::max(damping / 16.0, 1e-14);
    if (gain > min_gain) return std::nullopt;
    return Termination::tolerance;
  }
  return Termination::damping_limit;
}

/// Steps along the axes, halved when none helps.
LeastSquaresResult search_axes(const LeastSquaresProblem& problem, LeastSquaresResult now) {
  double size = 0.05;
  for (int round = 0; round < kMaxRounds && size > 1e-9; ++round) {
    bool better = false;
    for (Index i = 0; i < now.parameters.size(); ++i) {
      for (const double sign : {1.0, -1.0}) {
        const VectorXd next = clamped(problem, moved(now.parameters, i, sign * size * problem.scale[i]));
        const double sum = problem.residuals(next).squaredNorm();
        if (!(sum < now.sum_of_squares * (1.0 - 4.0 * kEpsilon))) continue;
        now.parameters = next;
        now.sum_of_squares = sum;
        better = true;
      }
    }
    if (!better) size *= 0.5;
  }
  return now;
}

/// Indices of the candidates, smallest sum of squares first.
std::vector<std::size_t> ranked(const LeastSquaresProblem& problem, const std::vector<VectorXd>& candidates) {
  std::vector<double> sums;
  for (const VectorXd& c : candidates) sums.push_back(problem.residuals(clamped(problem, c)).squaredNorm());
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sums[a] < sums[b]; });
  return order;
}

}  // namespace

MatrixXd jacobian(const LeastSquaresProblem& problem, const VectorXd& at) {
  if (problem.derivatives) return problem.derivatives(at);
  MatrixXd out(problem.residuals(at).size(), at.size());
  for (Index i = 0; i < at.size(); ++i) out.col(i) = derivative(problem, at, i);
  return out;
}

LeastSquaresResult levenberg_marquardt(const LeastSquaresProblem& problem, const VectorXd& start) {
  LeastSquaresResult now{.parameters = clamped(problem, start)};
  now.sum_of_squares = problem.residuals(now.parameters).squaredNorm();
  if (!std::isfinite(now.sum_of_squares)) {
    now.termination = Termination::not_finite;
    return now;
  }
  double damping = 1e-3;
  while (now.iterations < kMaxIterations) {
    const auto stop = improve(problem, now, damping);
    ++now.iterations;
    if (!stop) continue;
    now.termination = *stop;
    break;
  }
  assert((now.parameters.array() >= problem.lower.array()).all() &&
         (now.parameters.array() <= problem.upper.array()).all());
  return now;
}

LeastSquaresResult minimize_smooth(const LeastSquaresProblem& problem, const VectorXd& first,
                                   const std::vector<VectorXd>& candidates, std::size_t tries) {
  LeastSquaresResult best = levenberg_marquardt(problem, first);
  const std::vector<std::size_t> order = ranked(problem, candidates);
  for (std::size_t k = 0; k < std::min(tries, order.size()); ++k) {
    const LeastSquaresResult other = levenberg_marquardt(problem, candidates[order[k]]);
    if (other.sum_of_squares < best.sum_of_squares) best = other;
  }
  return best;
}

LeastSquaresResult minimize(const LeastSquaresProblem& problem, const VectorXd& first,
                            const std::vector<VectorXd>& candidates, std::size_t tries) {
  const LeastSquaresResult best = minimize_smooth(problem, first, candidates, tries);
  const LeastSquaresResult found = search_axes(problem, best);
  if (!(found.sum_of_squares < best.sum_of_squares)) return best;
  return levenberg_marquardt(problem, found.parameters);
}

std::optional<MatrixXd> unscaled_covariance(const MatrixXd& jac, double rank_tolerance) {
  const Index n = jac.cols();
  if (n == 0) return MatrixXd(0, 0);
  const VectorXd lengths = jac.colwise().stableNorm();
  if (jac.rows() < n || !(lengths.minCoeff() > 0.0) || !jac.allFinite()) return std::nullopt;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(jac * lengths.cwiseInverse().asDiagonal());
  qr.setThreshold(rank_tolerance);
  if (qr.rank() < n) return std::nullopt;
  const MatrixXd inverse_r =
      qr.matrixR().topRows(n).triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n));
  const MatrixXd half = lengths.cwiseInverse().asDiagonal() * (qr.colsPermutation() * inverse_r);
  MatrixXd covariance = half * half.transpose();
  assert(covariance.isApprox(covariance.transpose(), 1e-12) && covariance.diagonal().minCoeff() > 0.0);
  return covariance;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Eigenvalues of I - H below this: the cluster alone determines a parameter, and its residual there is
/// rounding.
constexpr double kNoResidual = 1e-6;

/// The symmetric matrix that gives the residuals of a cluster the variance of its errors: (I - H)^(-1/2).
MatrixXd bias_reduction(const MatrixXd& leverage) {
  const Index n = leverage.rows();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(MatrixXd::Identity(n, n) - leverage);
  const VectorXd factors = axes.eigenvalues().unaryExpr(
      [](double value) { return value > kNoResidual ? 1.0 / std::sqrt(value) : 0.0; });
  return axes.eigenvectors() * factors.asDiagonal() * axes.eigenvectors().transpose();
}

/// Satterthwaite's: of the quadratic form whose eigenvalues are those of the Gram matrix of `terms`, twice
/// the square of its mean over its variance.
double satterthwaite(const MatrixXd& terms) {
  const MatrixXd gram = terms.transpose() * terms;
  const double spread = gram.squaredNorm();
  return spread > 0.0 ? std::max(1.0, gram.trace() * gram.trace() / spread) : 1.0;
}

}  // namespace

ClusteredCovariance clustered_covariance(const MatrixXd& jacobian, const VectorXd& residuals,
                                         const std::vector<std::vector<Index>>& clusters) {
  const Index rows = jacobian.rows(), parameters = jacobian.cols();
  const auto count = static_cast<Index>(clusters.size());
  assert(residuals.size() == rows && rows >= parameters);
  // Parameters from residuals.
  const MatrixXd inverse = jacobian.colPivHouseholderQr().solve(MatrixXd::Identity(rows, rows));
  const MatrixXd leverage = jacobian * inverse;
  MatrixXd score(parameters, count);
  std::vector<MatrixXd> terms(static_cast<std::size_t>(parameters), MatrixXd(rows, count));
  for (Index g = 0; g < count; ++g) {
    const auto& members = clusters[static_cast<std::size_t>(g)];
    const MatrixXd weights = inverse(Eigen::all, members) * bias_reduction(leverage(members, members));
    score.col(g) = weights * residuals(members);
    for (Index k = 0; k < parameters; ++k) {
      const VectorXd w = weights.row(k).transpose();
      VectorXd term = -leverage(Eigen::all, members) * w;
      term(members) += w;
      terms[static_cast<std::size_t>(k)].col(g) = term;
    }
  }
  ClusteredCovariance out{score * score.transpose(), VectorXd(parameters)};
  for (Index k = 0; k < parameters; ++k)
    out.degrees_of_freedom[k] = satterthwaite(terms[static_cast<std::size_t>(k)]);
  return out;
}

double least_likely_chi2(double degrees_of_freedom) {
  constexpr double kByChance = 0.02;
  return degrees_of_freedom > 0.0 ? statistics::chi_squared_quantile(degrees_of_freedom, kByChance) : 0.0;
}

double least_robust_share(double degrees_of_freedom) {
  return degrees_of_freedom < kFewDegrees ? 1.0 : least_likely_chi2(degrees_of_freedom) / degrees_of_freedom;
}

std::vector<std::vector<Eigen::Index>> rows_of_pairs(const std::vector<std::vector<std::size_t>>& clusters) {
  std::vector<std::vector<Eigen::Index>> out;
  for (const auto& cluster : clusters) {
    out.emplace_back();
    for (const std::size_t i : cluster)
      for (const Eigen::Index component : {0, 1})
        out.back().push_back(static_cast<Eigen::Index>(2 * i) + component);
  }
  return out;
}

}  // namespace strobe::impact
