// The posterior of the contact mechanics' coefficients, in the coordinates of rebound_model.hpp: its Laplace
// approximation at the mode, the normal, or t, distribution with the curvature there, and samples of it;
// intervals by quantiles, correlations, and what the data do not tell.
//
// With U the weighted sum of squares over the residuals' variance plus that of the prior, the density is
// exp(-U/2) where the variance is stated. Where the fit tells the variance it is integrated over it, a t of
// the fit's degrees of freedom nu: (1 + (U - U_least)/nu)^(-(nu + p)/2). With CovarianceScale::clustered the
// residuals need not be alike nor independent: U is taken at mode + C·(x - mode), C such that the curvature
// is that of the cluster-robust covariance (R. Chandler and S. Bate, Biometrika 94, 2007; M. Ribatet, D.
// Cooley and A. Davison, Statistica Sinica 22, 2012). Deterministic for a seed; thread-safe; allocates.
#pragma once

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

/// Completes the parameters, the covariance and the posterior of a fit of ode at its least.
///
/// PosteriorMethod::automatic samples from the Laplace approximation by importance (importance_sampling.hpp),
/// which is the check of it; where the two do not match well enough, by adaptive Metropolis. Of a sample that
/// is worth fewer than a hundred draws nothing is used: then it is the approximation, and not reliable.
void add_posterior(const Fitter& least, ModelFit& fit);

}  // namespace strobe::impact
