#include "common/impact/fit/fitter.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "common/impact/fit/rebound_model.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr std::size_t kStartsTried = 6;
constexpr std::size_t kContactStartsTried = 2;  ///< its sum of squares is smooth
constexpr double kContactFunctionTolerance = 1e-7;
constexpr double kCoordinateReach = 8.0;  ///< sds of the prior
constexpr double kFirstVariance = 0.1;    ///< of residuals without stated sds, (m/s)²
constexpr int kVarianceRounds = 3;
constexpr double kMinVariance = 1e-12;  ///< of residuals that are rounding
constexpr int kMaxReweightings = 12;
constexpr double kProfileTolerance =
    1e-9;  ///< of a sum of squares whose rise by a hundredth and more matters
constexpr double kPoolingLevel = 0.25;
/// Shots beyond the first of their series: two residuals each, so that the mean square within has an sd of
/// half of it.
constexpr double kMinRepetitions = 4.0;

/// Those of the closed forms come first.
constexpr std::size_t kFormParameters = index(Parameter::alpha) + 1;

std::vector<std::vector<std::size_t>> each_alone(std::size_t count) {
  std::vector<std::vector<std::size_t>> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = {i};
  return out;
}

}  // namespace

std::vector<std::vector<std::size_t>> series_of(std::span<const Observation> observations) {
  std::map<std::string, std::size_t> places;
  std::vector<std::vector<std::size_t>> out;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto [at, added] = places.try_emplace(observations[i].series, out.size());
    if (added) out.emplace_back();
    out[at->second].push_back(i);
  }
  return out.size() > 1 ? out : each_alone(observations.size());
}

Fitter::Fitter(std::span<const Observation> observations, const FitOptions& options)
    : observations_(observations), options_(&options), values_(options.start) {
  for (std::size_t i = 0; i < kParameterCount; ++i)
    if (options.free[i]) free_.push_back(static_cast<Parameter>(i));
  // Where all dwell times are measured, nothing depends on it.
  if (std::ranges::all_of(observations, [](const Observation& o) { return o.dwell_s > 0.0; }))
    std::erase(free_, Parameter::dwell_s);
  if (options.weighting == Weighting::equal) variance_ = kFirstVariance;
  weights_.resize(observations.size(), equal_weight());
  if (options.weighting == Weighting::stated_sd) reweight(false);
  series_ = series_of(observations);
}

void Fitter::search() {
  search_with_this_scatter();
  if (options_->scale != CovarianceScale::clustered || free_.empty()) return;
  estimate_scatter();
  if (scatters()) search_with_this_scatter();
}

void Fitter::search_with_this_scatter() {
  fit_once(kStartsTried);
  if (options_->weighting == Weighting::stated_sd) iterate_weights();
}

void Fitter::refine() {
  if (free_.empty()) return;
  LeastSquaresProblem near = problem();
  near.function_tolerance = kProfileTolerance;
  values_ = with(levenberg_marquardt(near, free_values()).parameters);
}

Fitter Fitter::with_fixed(Parameter parameter, double value) const {
  Fitter out(*this);
  out.values_[index(parameter)] = value;
  std::erase(out.free_, parameter);
  return out;
}

bool Fitter::fits(Parameter parameter) const {
  return std::find(free_.begin(), free_.end(), parameter) != free_.end();
}

VectorXd Fitter::free_values() const {
  VectorXd out(static_cast<Index>(free_.size()));
  for (std::size_t k = 0; k < free_.size(); ++k)
    out[static_cast<Index>(k)] = coordinate_of(options_->model, free_[k], values_[index(free_[k])]);
  return out;
}

VectorXd Fitter::whitened_at(const VectorXd& at) const {
  const ParameterValues values = with(at);
  VectorXd out(static_cast<Index>(2 * observations_.size()));
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& o = observations_[i];
    const auto predicted = rebound_of(options_->model, values, options_->diameter_m, inputs_of(o));
    if (!predicted) {  // coefficients of the contact for which it takes too many steps
      assert(options_->model == ReboundModel::ode);
      return VectorXd::Constant(out.size(), std::numeric_limits<double>::infinity());
    }
    const Vector2d residual(
        predicted->lift_off.vx_mps - o.lift_off.vx_mps,
        0.5 * options_->diameter_m * (predicted->lift_off.omega_radps - o.lift_off.omega_radps));
    out.segment<2>(static_cast<Index>(2 * i)) = weights_[i] * residual;
  }
  return out;
}

/// The share is 1 - sd within / sd of a mean times the root of n, so that what is left has the same variance
/// everywhere.
void Fitter::demean(VectorXd& residuals) const {
  if (!scatters()) return;
  for (const auto& series : series_) {
    const auto n = static_cast<double>(series.size());
    Vector2d mean = Vector2d::Zero();
    for (const std::size_t i : series) mean += residuals.segment<2>(static_cast<Index>(2 * i)) / n;
    mean *= 1.0 - 1.0 / std::sqrt(1.0 + n * scatter_);
    for (const std::size_t i : series) residuals.segment<2>(static_cast<Index>(2 * i)) -= mean;
  }
}

VectorXd Fitter::residuals_at(const VectorXd& at) const {
  VectorXd out = whitened_at(at);
  demean(out);
  if (options_->model != ReboundModel::ode) return out;
  VectorXd both(out.size() + at.size());
  both << out, prior_rows().cwiseProduct(at - prior_means());
  return both;
}

VectorXd Fitter::prior_means() const {
  VectorXd out(static_cast<Index>(free_.size()));
  for (std::size_t k = 0; k < free_.size(); ++k)
    out[static_cast<Index>(k)] = prior_of(options_->model, free_[k])->mean;
  return out;
}

/// In units of the residuals' own sd.
VectorXd Fitter::prior_rows() const {
  VectorXd out(static_cast<Index>(free_.size()));
  for (std::size_t k = 0; k < free_.size(); ++k)
    out[static_cast<Index>(k)] = std::sqrt(variance_) / prior_of(options_->model, free_[k])->sd;
  return out;
}

/// Of residuals_at(), for the contact mechanics. 0 where a derivative cannot be had.
Eigen::MatrixXd Fitter::contact_jacobian_at(const VectorXd& at) const {
  const ParameterValues values = with(at);
  const auto rows = static_cast<Index>(2 * observations_.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows + at.size(), at.size());
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const auto gradient = contact_gradient(values, options_->diameter_m, inputs_of(observations_[i]));
    if (!gradient) continue;
    for (Index k = 0; k < at.size(); ++k) {
      const Parameter p = free_[static_cast<std::size_t>(k)];
      out.col(k).segment<2>(static_cast<Index>(2 * i)) =
          slope_at(options_->model, p, at[k]) *
          (weights_[i] * Vector2d(gradient->vx[index(p)], gradient->spin[index(p)]));
    }
  }
  for (Index k = 0; k < at.size(); ++k) {
    VectorXd column = out.col(k).head(rows);
    demean(column);
    out.col(k).head(rows) = column;
  }
  out.bottomRows(at.size()) = prior_rows().asDiagonal();
  return out;
}

LeastSquaresProblem Fitter::problem() const {
  const auto n = static_cast<Index>(free_.size());
  const double radius = 0.5 * options_->diameter_m;
  const ParameterValues scales{0.1, 0.1, 0.1 * radius, 1.0, 0.1, 0.1, 0.1, 0.1, 0.1};
  LeastSquaresProblem out{.residuals = [this](const VectorXd& at) { return residuals_at(at); },
                          .lower = VectorXd(n),
                          .upper = VectorXd(n),
                          .scale = VectorXd(n)};
  for (Index k = 0; k < n; ++k) {
    const Parameter p = free_[static_cast<std::size_t>(k)];
    out.lower[k] = lower_bound(p);
    out.upper[k] = upper_bound(p, radius);
    out.scale[k] = scales[index(p)];
    if (const auto prior = prior_of(options_->model, p)) {
      out.scale[k] = 0.1 * prior->sd;
      out.lower[k] = prior->mean - kCoordinateReach * prior->sd;
      out.upper[k] = prior->mean + kCoordinateReach * prior->sd;
    }
  }
  if (options_->model == ReboundModel::ode) {
    out.derivatives = [this](const VectorXd& at) { return contact_jacobian_at(at); };
    out.function_tolerance = kContactFunctionTolerance;
  }
  return out;
}

ParameterValues Fitter::with(const VectorXd& at) const {
  ParameterValues out = values_;
  for (std::size_t k = 0; k < free_.size(); ++k)
    out[index(free_[k])] = value_at(options_->model, free_[k], at[static_cast<Index>(k)]);
  return out;
}

Matrix2d Fitter::equal_weight() const {
  return Vector2d(std::sqrt(options_->vx_weight), std::sqrt(options_->spin_weight)).asDiagonal();
}

/// Whitening: the inverse of the Cholesky factor of the residual's covariance.
void Fitter::reweight(bool with_inputs) {
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& o = observations_[i];
    InputCovariance c;
    if (with_inputs) c = input_covariance(options_->model, values_, options_->diameter_m, o);
    c.vx += std::pow(o.lift_off_sd.vx_mps, 2);
    c.spin += std::pow(0.5 * options_->diameter_m * o.lift_off_sd.omega_radps, 2);
    const double first = std::sqrt(c.vx);
    const double across = c.cross / first;
    const double second = std::sqrt(std::max(c.spin - across * across, std::numeric_limits<double>::min()));
    weights_[i] << 1.0 / first, 0.0, -across / (first * second), 1.0 / second;
  }
}

/// From the mean squares between and within the clusters, the parameters taken from those between.
void Fitter::estimate_scatter() {
  const VectorXd residuals = whitened_at(free_values());
  double within = 0.0, between = 0.0, squares = 0.0;
  for (const auto& series : series_) {
    const auto n = static_cast<double>(series.size());
    Vector2d mean = Vector2d::Zero();
    for (const std::size_t i : series) mean += residuals.segment<2>(static_cast<Index>(2 * i)) / n;
    for (const std::size_t i : series)
      within += (residuals.segment<2>(static_cast<Index>(2 * i)) - mean).squaredNorm();
    between += n * mean.squaredNorm();
    squares += n * n;
  }
  const auto total = static_cast<double>(observations_.size());
  const auto groups = static_cast<double>(series_.size());
  const double left = 2.0 * groups - static_cast<double>(free_.size());
  scatter_ = 0.0;
  if (left < 1.0 || total - groups < kMinRepetitions || !(within > 0.0)) return;
  const double freedom_within = 2.0 * (total - groups);
  const double ratio = (between / left) / (within / freedom_within);
  if (ratio <= 1.0 || statistics::f_tail(ratio, left, freedom_within) > kPoolingLevel) return;
  const double typical_size = (total - squares / total) / (groups - 1.0);
  scatter_ = (ratio - 1.0) / typical_size;
}

void Fitter::fit_once(std::size_t tries) {
  if (free_.empty()) {
    termination_ = Termination::no_free_parameter;
    return;
  }
  const auto starts = tries > 0 ? candidates() : std::vector<VectorXd>{};
  const LeastSquaresResult found =
      options_->model == ReboundModel::ode
          ? minimize_smooth(problem(), free_values(), starts, std::min(tries, kContactStartsTried))
          : minimize(problem(), free_values(), starts, tries);
  values_ = with(found.parameters);
  termination_ = found.termination;
}

/// The weights depend on the parameters through the inputs' errors: alternate until the parameters converge.
void Fitter::iterate_weights() {
  const VectorXd scale = problem().scale;
  for (int i = 0; i < kMaxReweightings; ++i) {
    const VectorXd before = free_values();
    reweight(true);
    fit_once(i == 0 ? kStartsTried : 0);
    if (((free_values() - before).array().abs() <= 1e-7 * scale.array()).all()) return;
  }
}

/// A grid over the free parameters; of the contact mechanics a coarse one, over what makes it grip.
std::vector<VectorXd> Fitter::candidates() const {
  const double radius = 0.5 * options_->diameter_m;
  if (options_->model == ReboundModel::ode) {
    std::vector<VectorXd> out;
    for (const double mu : {0.3, 0.5, 0.9}) {
      for (const double stiffness : {0.6, 1.5}) {
        Fitter at(*this);
        at.set_if_free(Parameter::mu, mu);
        at.set_if_free(Parameter::stiffness_ratio, stiffness);
        out.push_back(at.free_values());
      }
    }
    return out;
  }
  const std::array<std::vector<double>, kFormParameters> grid{{{0.15, 0.35, 0.55, 0.8},
                                                               {0.0, 0.15, 0.5},
                                                               {0.01 * radius, 0.08 * radius, 0.2 * radius},
                                                               {0.3, 2.5, 10.0},
                                                               {0.4, 0.5, 0.6}}};
  std::vector<VectorXd> out{free_values()};
  for (std::size_t k = 0; k < free_.size(); ++k) {
    std::vector<VectorXd> longer;
    for (const VectorXd& c : out) {
      for (const double value : grid[index(free_[k])]) {
        longer.push_back(c);
        longer.back()[static_cast<Index>(k)] = value;
      }
    }
    out = std::move(longer);
  }
  return out;
}

void Fitter::set_if_free(Parameter parameter, double value) {
  if (fits(parameter)) values_[index(parameter)] = value;
}

/// The prior counts for what it is worth against the residuals, whose variance the fit tells.
void Fitter::search_with_prior() {
  search();
  if (options_->scale == CovarianceScale::stated || free_.empty()) return;
  for (int i = 0; i < kVarianceRounds; ++i) {
    variance_ = std::max(reduced(chi2(), std::max(1, degrees_of_freedom())), kMinVariance);
    fit_once(0);
  }
}

double Fitter::chi2() const {
  return residuals_at(free_values()).head(static_cast<Index>(2 * observations_.size())).squaredNorm();
}

double Fitter::log_determinant() const {
  double sum = 0.0;
  for (const Matrix2d& w : weights_) sum -= 2.0 * std::log(w(0, 0) * w(1, 1));
  return sum;
}

std::vector<std::vector<std::size_t>> Fitter::clusters() const {
  return scatters() ? series_ : each_alone(observations_.size());
}

double Fitter::reduced(double chi2, int dof) const {
  double rounding = 0.0;
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& o = observations_[i];
    const double largest = std::abs(o.touchdown.vx_mps) + std::abs(o.touchdown.vy_mps) +
                           options_->diameter_m * std::abs(o.touchdown.omega_radps);
    const Vector2d error = Vector2d::Constant(16.0 * std::numeric_limits<double>::epsilon() * largest);
    rounding += (weights_[i].cwiseAbs() * error).squaredNorm();
  }
  return chi2 <= rounding ? 0.0 : chi2 / dof;
}

int Fitter::degrees_of_freedom() const {
  return static_cast<int>(2 * observations_.size()) - static_cast<int>(free_.size());
}

int Fitter::degrees_of_freedom_between() const {
  if (!scatters()) return degrees_of_freedom();
  return static_cast<int>(2 * series_.size()) - static_cast<int>(free_.size());
}

}  // namespace strobe::impact
