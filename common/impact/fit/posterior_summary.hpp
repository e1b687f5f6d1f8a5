// The posterior of the contact mechanics' coefficients, sampled and told: intervals by quantiles, correlations, and what the
// data do not tell. Deterministic for a seed; thread-safe; allocates.
#pragma once

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

/// Completes the parameters, the covariance and the posterior of a fit of ode at its least.
///
/// PosteriorMethod::automatic samples from the Laplace approximation by importance (importance_sampling.hpp), which is the
/// check of it; where the two do not match well enough, by adaptive Metropolis.
void add_posterior(const Fitter& least, ModelFit& fit);

}  // namespace strobe::impact
