// The search of a rebound model's least sum of squares: weights, scatter between conditions, starts. What
// fit() is made of. Deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <span>
#include <vector>

#include "common/impact/fit/bounded_least_squares.hpp"
#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

/// The observations of each series, by their indices; each on its own if there is only one series.
std::vector<std::vector<std::size_t>> series_of(std::span<const Observation> observations);

/// A fit in progress: the free parameters and the weights of the residuals.
///
/// With CovarianceScale::clustered the shots of a series may share what the model misses there. Whether they
/// do, the mean squares of the residuals between and within the series tell, by an F-test at the level of .25
/// that is usual for pooling (T. Bancroft, Biometrics 20, 1964). If so each series is a cluster with a random
/// effect, whose variance over that of the weighted residuals is estimated (P. Swamy and S. Arora,
/// Econometrica 40, 1972) and taken into account by quasi-demeaning (W. Fuller and G. Battese, Journal of
/// Econometrics 2, 1974): each residual less a share of its cluster's mean. If not, each shot is a cluster of
/// its own.
class Fitter {
 public:
  /// The arguments must outlive it; they passed the checks of fit().
  Fitter(std::span<const Observation> observations, const FitOptions& options);

  /// From several starts, the weights following the parameters.
  void search();
  /// Likewise for ode, whose priors count by the residuals' variance.
  void search_with_prior();
  /// Likewise, but for the scatter between the clusters, which stays.
  void search_with_this_scatter();
  /// From the present values, under the present weights, by derivatives alone: cheap where the least is near.
  void refine();
  /// The same with a parameter that is not fitted, from the present values of the others.
  Fitter with_fixed(Parameter parameter, double value) const;
  const FitOptions& options() const { return *options_; }
  std::span<const Observation> observations() const { return observations_; }
  const std::vector<Parameter>& free() const { return free_; }
  bool fits(Parameter parameter) const;
  const ParameterValues& values() const { return values_; }
  Eigen::VectorXd free_values() const;
  Termination termination() const { return termination_; }  ///< of the last search

  /// Weighted residuals, predicted less measured: two for each observation; for ode, after them one for each
  /// parameter by its prior. `at` are coordinates (rebound_model.hpp).
  Eigen::VectorXd residuals_at(const Eigen::VectorXd& at) const;
  double chi2() const;
  /// Of the weights: the logarithm of the determinant of the residuals' covariance, which chi2 lacks of -2
  /// log likelihood.
  double log_determinant() const;
  /// chi2/dof; 0 where the residuals are within rounding.
  double reduced(double chi2, int dof) const;
  /// Two for each observation, less the free parameters.
  int degrees_of_freedom() const;
  /// Of what a parameter's sd rests on: those of the clusters where they scatter.
  int degrees_of_freedom_between() const;
  std::vector<std::vector<std::size_t>> clusters() const;
  /// What the residuals' variance is taken for where they are compared with the prior.
  double variance() const { return variance_; }
  bool scatters() const { return scatter_ > 0.0; }  ///< from series to series
  LeastSquaresProblem problem() const;

 private:
  ParameterValues with(const Eigen::VectorXd& at) const;
  Eigen::VectorXd whitened_at(const Eigen::VectorXd& at) const;
  void demean(Eigen::VectorXd& residuals) const;
  Eigen::Matrix2d equal_weight() const;
  void reweight(bool with_inputs);
  void estimate_scatter();
  void fit_once(std::size_t tries);
  void iterate_weights();
  void set_if_free(Parameter parameter, double value);
  Eigen::VectorXd prior_means() const;
  Eigen::VectorXd prior_rows() const;
  Eigen::MatrixXd contact_jacobian_at(const Eigen::VectorXd& at) const;
  std::vector<Eigen::VectorXd> candidates() const;

  std::span<const Observation> observations_;
  const FitOptions* options_;
  ParameterValues values_;
  std::vector<Parameter> free_;
  std::vector<Eigen::Matrix2d> weights_;
  std::vector<std::vector<std::size_t>> series_;
  double variance_ = 1.0;
  double scatter_ = 0.0;  ///< variance of the clusters' effects over that of one residual
  Termination termination_ = Termination::iteration_limit;
};

}  // namespace strobe::impact
