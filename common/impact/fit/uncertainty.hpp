// Standard deviations, limits, intervals and covariance of a fit at its least sum of squares. Deterministic; thread-safe;
// allocates.
#pragma once

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

/// Completes the parameters that are free, but for those that are undetermined already, and the covariance; `fit` has its
/// variance_scale. Fails with not_identifiable.
///
/// With CovarianceScale::clustered a parameter's variance is the robust one of clustered_covariance(); where that has few
/// degrees of freedom, since few shots or series determine the parameter, the larger of it and that of all residuals
/// alike: a variance from few residuals may be small by chance.
tl::expected<void, FitFailure> add_uncertainty(const Fitter& fitter, ModelFit& fit);

}  // namespace strobe::impact
