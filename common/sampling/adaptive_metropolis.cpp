#include "common/sampling/adaptive_metropolis.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/sampling/sample.hpp"

namespace strobe::sampling {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kShorter = 0.2;       ///< the second step over the first
constexpr int kAdaptEvery = 50;        ///< steps
constexpr double kPriorSteps = 200.0;  ///< that the first covariance counts for

/// Mean and covariance of a chain so far, the start's counted as so many steps.
class RunningCovariance {
 public:
  RunningCovariance(const VectorXd& mean, const MatrixXd& covariance)
      : count_(kPriorSteps), mean_(mean), sum_(kPriorSteps * covariance) {}
  void add(const VectorXd& x) {
    count_ += 1.0;
    const VectorXd away = x - mean_;
    mean_ += away / count_;
    sum_ += away * (x - mean_).transpose();
  }
  MatrixXd covariance() const { return sum_ / count_; }

 private:
  double count_;
  VectorXd mean_;
  MatrixXd sum_;
};

/// min(1, exp(log ratio)).
double acceptance(double to, double from) { return std::exp(std::min(0.0, to - from)); }

/// One chain's walk.
class Walk {
 public:
  Walk(const LogDensity& density, VectorXd at, double log_density, const MatrixXd& covariance,
       RandomNumbers& random)
      : density_(density), random_(random), at_(std::move(at)), log_(log_density), seen_(at_, covariance) {
    set_step(covariance);
  }

  void step(int number) {
    const VectorXd first = at_ + root_ * random_.normals(at_.size());
    const double log_first = value(first);
    const double one = acceptance(log_first, log_);
    if (random_.uniform() < one) {
      move(first, log_first);
    } else {
      delayed(first, log_first, one);
    }
    seen_.add(at_);
    if (number % kAdaptEvery == 0) set_step(seen_.covariance());
  }

  const VectorXd& at() const { return at_; }
  int accepted() const { return accepted_; }
  int evaluations() const { return evaluations_; }

 private:
  double value(const VectorXd& x) {
    ++evaluations_;
    const double out = density_(x);
    return std::isnan(out) ? -std::numeric_limits<double>::infinity() : out;
  }

  void move(const VectorXd& to, double log_density) {
    at_ = to;
    log_ = log_density;
    ++accepted_;
  }

  /// The first step's proposal is that from either end, which the second's acceptance takes into account.
  void delayed(const VectorXd& first, double log_first, double one) {
    const VectorXd second = at_ + kShorter * (root_ * random_.normals(at_.size()));
    const double log_second = value(second);
    const double back = acceptance(log_first, log_second);
    if (back >= 1.0 || !std::isfinite(log_second)) return;
    const auto log_proposal = [&](const VectorXd& from) {
      return -0.5 * root_.triangularView<Eigen::Lower>().solve(first - from).squaredNorm();
    };
    const double log_ratio =
        log_second + log_proposal(second) + std::log1p(-back) - log_ - log_proposal(at_) - std::log1p(-one);
    if (random_.uniform() < std::exp(std::min(0.0, log_ratio))) move(second, log_second);
  }

  /// 2.38 over the root of the dimension is the best scale for a normal density (Gelman, Roberts and Gilks,
  /// 1996).
  void set_step(const MatrixXd& covariance) {
    const Eigen::LLT<MatrixXd> factor(covariance);
    if (factor.info() != Eigen::Success) return;
    root_ = 2.38 / std::sqrt(static_cast<double>(at_.size())) * MatrixXd(factor.matrixL());
  }

  const LogDensity& density_;
  RandomNumbers& random_;
  VectorXd at_;
  double log_;
  RunningCovariance seen_;
  MatrixXd root_;
  int accepted_ = 0;
  int evaluations_ = 0;
};

/// Each chain cut in two.
MatrixXd halves(const MatrixXd& chains) {
  const Index half = chains.cols() / 2;
  MatrixXd out(2 * chains.rows(), half);
  out << chains.leftCols(half), chains.rightCols(half);
  return out;
}

/// Mean variance within the chains, and the variance of a draw as within and between tell it.
struct Variances {
  double within = 0.0;
  double pooled = 0.0;
};

Variances variances_of(const MatrixXd& chains) {
  const auto n = static_cast<double>(chains.cols());
  const VectorXd means = chains.rowwise().mean();
  Variances out;
  out.within = (chains.colwise() - means).squaredNorm() / (static_cast<double>(chains.rows()) * (n - 1.0));
  const double between = chains.rows() > 1 ? (means.array() - means.mean()).square().sum() /
                                                 static_cast<double>(chains.rows() - 1)
                                           : 0.0;
  out.pooled = out.within * (n - 1.0) / n + between;
  return out;
}

/// Mean over the chains of the products of deviations `lag` apart.
double autocovariance(const MatrixXd& centred, Index lag) {
  const Index n = centred.cols() - lag;
  return centred.leftCols(n).cwiseProduct(centred.rightCols(n)).sum() /
         static_cast<double>(centred.rows() * centred.cols());
}

}  // namespace

double split_r_hat(const MatrixXd& chains) {
  const Variances v = variances_of(halves(chains));
  return v.within > 0.0 ? std::sqrt(v.pooled / v.within) : 1.0;
}

double effective_size(const MatrixXd& chains) {
  const MatrixXd cut = halves(chains);
  const Variances v = variances_of(cut);
  const auto draws = static_cast<double>(cut.size());
  if (!(v.pooled > 0.0)) return draws;
  const VectorXd means = cut.rowwise().mean();
  const MatrixXd centred = cut.colwise() - means;
  const auto correlation = [&](Index lag) {
    return 1.0 - (v.within - autocovariance(centred, lag)) / v.pooled;
  };
  double time = -1.0, last = std::numeric_limits<double>::infinity();
  for (Index lag = 0; lag + 1 < cut.cols(); lag += 2) {
    const double pair = std::min(last, correlation(lag) + correlation(lag + 1));
    if (pair <= 0.0) break;
    time += 2.0 * pair;
    last = pair;
  }
  return draws / std::max(time, 1.0 / std::log10(draws));
}

MetropolisSample adaptive_metropolis(const LogDensity& density, const VectorXd& start,
                                     const MatrixXd& covariance, const MetropolisOptions& options) {
  RandomNumbers random(options.seed);
  const MatrixXd root = covariance.llt().matrixL();
  const double log_start = density(start);
  const int burn = options.steps / 3, kept = options.steps - burn;
  MetropolisSample out;
  out.sample.points.resize(start.size(), static_cast<Index>(options.chains) * kept);
  for (int chain = 0; chain < options.chains; ++chain) {
    VectorXd from = start + root * random.normals(start.size());
    double log_from = density(from);
    if (!std::isfinite(log_from)) {
      from = start;
      log_from = log_start;
    }
    Walk walk(density, from, log_from, covariance, random);
    for (int step = 1; step <= options.steps; ++step) {
      walk.step(step);
      if (step > burn) out.sample.points.col(static_cast<Index>(chain) * kept + step - burn - 1) = walk.at();
      if (options.progress)
        options.progress((chain + static_cast<double>(step) / options.steps) / options.chains);
    }
    out.acceptance += static_cast<double>(walk.accepted()) / options.steps / options.chains;
    out.evaluations += walk.evaluations() + 1;
  }
  out.sample = unweighted(std::move(out.sample.points));
  out.effective_size.resize(start.size());
  out.r_hat.resize(start.size());
  for (Index k = 0; k < start.size(); ++k) {
    const VectorXd row = out.sample.points.row(k);
    const MatrixXd chains = Eigen::Map<const MatrixXd>(row.data(), kept, options.chains).transpose();
    out.effective_size[k] = effective_size(chains);
    out.r_hat[k] = split_r_hat(chains);
  }
  return out;
}

}  // namespace strobe::sampling
