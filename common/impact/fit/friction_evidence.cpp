#include "common/impact/fit/friction_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "common/impact/fit/regula_falsi.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

/// Least twice the logarithm of the likelihood ratio for a contact that slides, or grips: 3.5 sd, as the
/// contact that looks most like it is one of many.
constexpr double kSlidingEvidence = 12.0;
constexpr double kLimitTolerance = 1e-7;  ///< relative
constexpr double kStepDown = 0.05;        ///< first step to the limit, of the range down to the lower bound

/// Likelihoods with the weights that each fit gives the residuals, the variance known or estimated from the better one.
bool may_be_noise(const Fitter& least, const Fitter& without) {
  const double chi2 = least.chi2(), rise = without.chi2() - chi2;
  const double weights = without.log_determinant() - least.log_determinant();
  if (least.options().scale == CovarianceScale::stated) return rise + weights < kSlidingEvidence;
  const int dof = least.degrees_of_freedom(), between = least.degrees_of_freedom_between();
  if (dof < 1 || between < 1 || !(without.reduced(without.chi2(), dof) > 0.0)) return true;
  const double variance = least.reduced(chi2, dof);
  return variance > 0.0 && between * std::log1p(rise / (variance * between)) + weights < kSlidingEvidence;
}

/// The largest value that some contact depends on: that of mu which the contact with the most friction needs. Of e_x, its
/// upper bound.
double largest_that_matters(const Fitter& fitter, Parameter parameter) {
  const FitOptions& options = fitter.options();
  if (parameter != Parameter::mu) return upper_bound(parameter, 0.5 * options.diameter_m);
  double largest = 0.0;
  for (const Comparison& c :
       compare(fitter.observations(), options.model, fitter.values(), options.diameter_m))
    largest = std::max(largest, std::abs(c.predicted.impulse_ratio));
  return largest;
}

/// The root of the sum of squares under a value of the parameter, from the best fit under the last one: it rises about
/// linearly beyond what the contacts allow.
class RootOfSquares {
 public:
  RootOfSquares(const Fitter& fitter, Parameter parameter) : fitter_(fitter), parameter_(parameter) {}

  double operator()(double value) {
    fitter_ = fitter_.with_fixed(parameter_, value);
    fitter_.refine();
    return std::sqrt(fitter_.chi2());
  }

 private:
  Fitter fitter_;
  Parameter parameter_;
};

/// The value below `high` below which the sum of squares has risen by `rise`, bracketed downwards; the lower bound if it
/// rises nowhere so far.
double crossing(const Fitter& fitter, Parameter parameter, double high, double rise) {
  RootOfSquares root(fitter, parameter);
  const double level = std::sqrt(fitter.chi2() + rise);
  const double least = lower_bound(parameter);
  const double tolerance = kLimitTolerance * std::abs(high);
  // What was found on the way down: from another start the same value may end in another valley, above the level, too.
  FunctionValue below{high, std::sqrt(fitter.chi2()) - level}, low = below;
  for (double step = kStepDown * (high - least); low.at > least && !(low.value > 0.0); step *= 2.0) {
    below = low;
    low.at = std::max(least, low.at - step);
    low.value = root(low.at) - level;
  }
  if (!(low.value > 0.0)) return least;
  return regula_falsi([&](double value) { return root(value) - level; }, low, below, tolerance).at;
}

}  // namespace

std::optional<double> limit_without_evidence(const Fitter& least, Parameter parameter) {
  if (!least.fits(parameter)) return std::nullopt;
  Fitter without = least.with_fixed(parameter, upper_bound(parameter, 0.5 * least.options().diameter_m));
  without.search_with_this_scatter();
  const double chi2 = without.chi2();
  if (!may_be_noise(least, without)) return std::nullopt;
  const int dof = without.degrees_of_freedom(), between = std::max(1, without.degrees_of_freedom_between());
  const bool stated = least.options().scale == CovarianceScale::stated;
  const double t =
      statistics::student_t_quantile(stated ? statistics::kAsGoodAsNormal : between, 1.0 - kLimitLevel);
  const double rise = t * t * (stated ? 1.0 : without.reduced(chi2, dof));
  // Each with its own weights: the value of the least sum of squares is never excluded.
  return std::min(crossing(without, parameter, largest_that_matters(without, parameter), rise),
                  crossing(least, parameter, least.values()[index(parameter)], rise));
}

}  // namespace strobe::impact
