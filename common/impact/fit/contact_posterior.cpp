#include "common/impact/fit/contact_posterior.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/sampling/adaptive_metropolis.hpp"
#include "common/sampling/importance_sampling.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double t_quantile(double freedom) {
  return statistics::student_t_quantile(std::min(freedom, statistics::kAsGoodAsNormal),
                                        0.5 * (1.0 - kIntervalLevel));
}

/// The density and its Laplace approximation.
class ContactPosterior {
 public:
  /// Of a fit at its least, with free parameters; must outlive this. The weights stay as they are there.
  explicit ContactPosterior(const Fitter& least);

  const Eigen::VectorXd& mode() const { return mode_; }
  /// Of the Laplace approximation: the scale matrix of a t distribution with degrees_of_freedom().
  const Eigen::MatrixXd& scale() const { return scale_; }
  double degrees_of_freedom() const { return freedom_; }
  /// Of each parameter's own Student's t where CovarianceScale::clustered says so; the scale allows for it at
  /// 95 %.
  const Eigen::VectorXd& own_degrees_of_freedom() const { return own_freedom_; }
  /// Up to a constant; -infinity where the contact cannot be computed.
  double log_density(const Eigen::VectorXd& coordinates) const;

 private:
  void find_scale(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals);
  void adjust(const Eigen::MatrixXd& information);

  const Fitter& least_;
  Eigen::VectorXd mode_;
  Eigen::MatrixXd scale_;
  Eigen::VectorXd own_freedom_;
  Eigen::MatrixXd adjustment_;  ///< C; empty: the identity
  double freedom_ = 0.0;
  double least_squares_ = 0.0;
};

ContactPosterior::ContactPosterior(const Fitter& least) : least_(least), mode_(least.free_values()) {
  const VectorXd residuals = least.residuals_at(mode_);
  least_squares_ = residuals.squaredNorm();
  const bool stated = least.options().scale == CovarianceScale::stated;
  freedom_ = stated ? statistics::kAsGoodAsNormal : std::max(1, least.degrees_of_freedom_between());
  find_scale(jacobian(least.problem(), mode_), residuals);
}

/// The prior's rows have the variance that they state; only the data's are judged by their residuals.
void ContactPosterior::find_scale(const MatrixXd& jac, const VectorXd& residuals) {
  const Index n = mode_.size(), rows = jac.rows() - n;
  const MatrixXd information = jac.transpose() * jac / least_.variance();
  scale_ = information.llt().solve(MatrixXd::Identity(n, n));
  own_freedom_ = VectorXd::Constant(n, freedom_);
  if (least_.options().scale != CovarianceScale::clustered) return;
  const ClusteredCovariance robust = clustered_covariance(jac, residuals, rows_of_pairs(least_.clusters()));
  const MatrixXd from_prior = scale_ * jac.bottomRows(n).transpose() / least_.variance();
  MatrixXd both = robust.covariance + least_.variance() * from_prior * from_prior.transpose();
  if (both.llt().info() != Eigen::Success || rows < n) return;
  VectorXd stretch(n);
  for (Index k = 0; k < n; ++k) {
    const double degrees = robust.degrees_of_freedom[k];
    const double variance = std::max(both(k, k), least_robust_share(degrees) * scale_(k, k));
    if (degrees >= kFewDegrees || least_.scatters()) own_freedom_[k] = degrees;
    stretch[k] = std::sqrt(variance / both(k, k)) * t_quantile(own_freedom_[k]) / t_quantile(freedom_);
  }
  scale_ = stretch.asDiagonal() * both * stretch.asDiagonal();
  adjust(information);
}

/// With L the root of the information, C turns the sphere Lᵀ(x - mode) into that of the scale, by the
/// symmetric root, which turns least.
void ContactPosterior::adjust(const MatrixXd& information) {
  const MatrixXd root = information.llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(root.transpose() * scale_ * root);
  const MatrixXd inner = axes.operatorInverseSqrt();
  adjustment_ = root.transpose().triangularView<Eigen::Upper>().solve(inner * root.transpose());
}

double ContactPosterior::log_density(const VectorXd& coordinates) const {
  const VectorXd at =
      adjustment_.size() > 0 ? VectorXd(mode_ + adjustment_ * (coordinates - mode_)) : coordinates;
  const double rise = (least_.residuals_at(at).squaredNorm() - least_squares_) / least_.variance();
  if (!std::isfinite(rise)) return -std::numeric_limits<double>::infinity();
  if (freedom_ >= statistics::kAsGoodAsNormal) return -0.5 * rise;
  // A mode that the search missed by its tolerance may lie a little lower.
  const double above = std::max(rise / freedom_, -0.5);
  return -0.5 * (freedom_ + static_cast<double>(mode_.size())) * std::log1p(above);
}

/// Draws that are worth so many independent ones give an interval's end to a tenth of an sd.
constexpr double kEnoughDraws = 300.0;
/// Worth fewer, an sd depends on the seed by 7 % and more; chains that hardly move have none.
constexpr double kMinDraws = 100.0;
constexpr double kMaxRHat = 1.05;
constexpr double kContactsOfARound = 5e5;
constexpr double kLowerLevel = 0.5 * (1.0 - kIntervalLevel);

struct Ends {
  double lower = 0.0, median = 0.0, upper = 0.0;
};

/// Of each coordinate by the Laplace approximation.
std::vector<Ends> laplace_ends(const ContactPosterior& posterior) {
  std::vector<Ends> out;
  const double t = statistics::student_t_quantile(posterior.degrees_of_freedom(), kLowerLevel);
  for (Index k = 0; k < posterior.mode().size(); ++k) {
    const double reach = t * std::sqrt(posterior.scale()(k, k)), mode = posterior.mode()[k];
    out.push_back({mode - reach, mode, mode + reach});
  }
  return out;
}

std::vector<Ends> sampled_ends(const sampling::Sample& sample) {
  std::vector<Ends> out;
  for (Index k = 0; k < sample.points.rows(); ++k) {
    const auto q = sample.quantiles(k, {kLowerLevel, 0.5, 1.0 - kLowerLevel});
    out.push_back({q[0], q[1], q[2]});
  }
  return out;
}

void by_importance(const ContactPosterior& posterior, const PosteriorOptions& options, Posterior& out) {
  const auto drawn = sampling::importance_sample(
      [&](const VectorXd& at) { return posterior.log_density(at); }, posterior.mode(), posterior.scale(),
      {.seed = options.seed,
       .draws = options.draws,
       .least_size = kEnoughDraws,
       .progress = options.progress});
  out.method = PosteriorMethod::importance;
  out.sample = drawn.sample;
  out.effective_size = drawn.sample.effective_size();
  out.pareto_shape = drawn.pareto_shape;
  out.evaluations += drawn.evaluations;
  out.reliable = drawn.good(kEnoughDraws);
}

/// From what importance sampling has found, if it was tried.
void by_metropolis(const ContactPosterior& posterior, const PosteriorOptions& options, Posterior& out) {
  MatrixXd first = posterior.scale();
  if (out.pareto_shape && *out.pareto_shape <= 1.0) first = out.sample.covariance();
  const auto drawn = sampling::adaptive_metropolis(
      [&](const VectorXd& at) { return posterior.log_density(at); }, posterior.mode(), first,
      {.seed = options.seed, .steps = std::max(60, 3 * options.draws / 2), .progress = options.progress});
  out.method = PosteriorMethod::metropolis;
  out.sample = drawn.sample;
  out.effective_size = drawn.effective_size.minCoeff();
  out.r_hat = drawn.r_hat.maxCoeff();
  out.acceptance = drawn.acceptance;
  out.evaluations += drawn.evaluations;
  out.reliable = *out.r_hat <= kMaxRHat && out.effective_size >= kEnoughDraws;
  if (out.effective_size >= kMinDraws) return;
  out.method = PosteriorMethod::laplace;
  out.sample = {};
}

PosteriorOptions with_draws(PosteriorOptions options, std::size_t shots) {
  const double chosen = std::clamp(kContactsOfARound / static_cast<double>(shots), 1500.0, 8000.0);
  if (options.draws == 0) options.draws = static_cast<int>(chosen);
  return options;
}

Posterior sampled(const ContactPosterior& posterior, const PosteriorOptions& options) {
  Posterior out;
  out.seed = options.seed;
  if (options.method == PosteriorMethod::laplace) return out;
  if (options.method != PosteriorMethod::metropolis) by_importance(posterior, options, out);
  const bool instead = options.method == PosteriorMethod::automatic && !out.reliable;
  if (options.method == PosteriorMethod::metropolis || instead) by_metropolis(posterior, options, out);
  return out;
}

/// Largest distance of an end of an interval from the Laplace approximation's, in its sds.
double largest_shift(const std::vector<Ends>& ends, const std::vector<Ends>& laplace) {
  double out = 0.0;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const double sd = (laplace[k].upper - laplace[k].lower) / 4.0;
    out = std::max({out, std::abs(ends[k].lower - laplace[k].lower) / sd,
                    std::abs(ends[k].upper - laplace[k].upper) / sd});
  }
  return out;
}

/// Of the coordinates; that of a t distribution is the scale's, larger.
MatrixXd laplace_covariance(const ContactPosterior& posterior) {
  const double wider =
      statistics::student_t_quantile(posterior.degrees_of_freedom(), statistics::kAboveOneSd);
  return wider * wider * posterior.scale();
}

/// Of a parameter's values: from a sample its own, else by the slope at the mode.
double value_sd(const Fitter& least, Parameter p, Index k, const Posterior& found, double coordinate_sd,
                double mode) {
  if (found.sample.points.size() == 0) return slope_at(least.options().model, p, mode) * coordinate_sd;
  const VectorXd values =
      found.sample.points.row(k).unaryExpr([&](double at) { return value_at(least.options().model, p, at); });
  const double mean = values.dot(found.sample.weights);
  return std::sqrt((values.array() - mean).square().matrix().dot(found.sample.weights));
}

/// Whether the data tell each coordinate by its share of the prior's sd, but no more of them than there are
/// directions in which the data tell as much: of one condition's shots, however many, two, by vx and spin.
std::vector<bool> told(const MatrixXd& covariance, const VectorXd& prior_sds) {
  constexpr double kToldVariance = kUntoldShare * kUntoldShare;
  const VectorXd per_prior = prior_sds.cwiseInverse();
  const MatrixXd in_priors = per_prior.asDiagonal() * covariance * per_prior.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(in_priors);  // as elsewhere: compiled once
  const auto directions = (axes.eigenvalues().array() <= kToldVariance).count();
  std::vector<bool> out;
  for (const double variance : in_priors.diagonal())
    out.push_back(variance <= kToldVariance &&
                  (in_priors.diagonal().array() < variance).count() < directions);
  return out;
}

}  // namespace

void add_posterior(const Fitter& least, ModelFit& fit) {
  if (least.free().empty()) return;
  const ContactPosterior posterior(least);
  const ReboundModel model = least.options().model;
  Posterior found = sampled(posterior, with_draws(least.options().posterior, least.observations().size()));
  const std::vector<Ends> laplace = laplace_ends(posterior);
  const std::vector<Ends> ends = found.sample.points.size() > 0 ? sampled_ends(found.sample) : laplace;
  found.laplace_shift = largest_shift(ends, laplace);
  const MatrixXd by_laplace = laplace_covariance(posterior);
  const MatrixXd covariance = found.sample.points.size() > 0 ? found.sample.covariance() : by_laplace;
  const VectorXd sd = covariance.diagonal().cwiseSqrt();
  found.parameters = least.free();
  found.correlation = sd.cwiseInverse().asDiagonal() * covariance * sd.cwiseInverse().asDiagonal();
  VectorXd value_sds(sd.size()), prior_sds(sd.size());
  for (Index k = 0; k < sd.size(); ++k)
    prior_sds[k] = prior_of(model, found.parameters[static_cast<std::size_t>(k)])->sd;
  const std::vector<bool> told_by_laplace = told(by_laplace, prior_sds);
  for (Index k = 0; k < sd.size(); ++k) {
    const Parameter p = least.free()[static_cast<std::size_t>(k)];
    const Ends& e = ends[static_cast<std::size_t>(k)];
    FittedParameter& out = fit.parameters[index(p)];
    const double share = sd[k] / prior_sds[k];
    const bool fitted = share <= kUntoldShare && told_by_laplace[static_cast<std::size_t>(k)];
    value_sds[k] = value_sd(least, p, k, found, sd[k], posterior.mode()[k]);
    out.status = fitted ? ParameterStatus::fitted : ParameterStatus::undetermined;
    out.sd = value_sds[k];
    out.lower = value_at(model, p, e.lower);
    out.upper = value_at(model, p, e.upper);
    out.degrees_of_freedom = posterior.own_degrees_of_freedom()[k];
    found.medians.push_back(value_at(model, p, e.median));
    found.prior_shares.push_back(share);
    found.coordinate_sds.push_back(sd[k]);
  }
  for (Index a = 0; a < sd.size(); ++a)
    for (Index b = 0; b < sd.size(); ++b)
      fit.covariance(static_cast<Index>(index(least.free()[static_cast<std::size_t>(a)])),
                     static_cast<Index>(index(least.free()[static_cast<std::size_t>(b)]))) =
          value_sds[a] * value_sds[b] * found.correlation(a, b);
  fit.posterior = std::move(found);
}

}  // namespace strobe::impact
