// Standard deviations, limits, intervals and covariance of a fit at its least sum of squares. Deterministic;
// thread-safe; allocates; some ten fits from near values for each end of an interval.
#pragma once

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

/// Completes the parameters that are free and the covariance; `fit` has its values and its variance_scale.
/// Fails with not_identifiable.
///
/// A fit only knows the friction coefficient if it knows that any contact slid, and the tangential
/// restitution of a grip if it knows that any gripped. Where noise alone may have made a contact look so, mu
/// or e_x is undetermined and has a lower limit.
///
/// With CovarianceScale::clustered a parameter's variance is the robust one of clustered_covariance(); where
/// that has few degrees of freedom, since few shots or series determine the parameter, the larger of it and
/// that of all residuals alike: a variance from few residuals may be small by chance.
///
/// Intervals are of the profile of the sum of squares: the values at which the best fit of the others is
/// worse by a step. Unlike value ± t sd they follow the kinks between regimes and the bounds. The step is
/// Student's t squared, times what the residuals say that the parameter's variance is over what the weights
/// say (R. Chandler and S. Bate, Biometrika 94, 2007), so that the interval is value ± t sd where the model
/// is linear.
tl::expected<void, FitFailure> add_uncertainty(const Fitter& fitter, ModelFit& fit);

}  // namespace strobe::impact
