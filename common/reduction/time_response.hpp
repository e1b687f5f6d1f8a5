// How a fit follows its images' times, to first order. Part of the reduction, not of its interface. Thread-safe;
// allocates.
#pragma once

#include <vector>

#include "common/reduction/surface_crossing.hpp"

namespace strobe::reduction {

/// Of each image, in the observations' order: the derivatives of the variables of Number by its time. [1/s]
///
/// An image whose flash came later by dt is one that lies v dt nearer, and is turned omega dt less: the fit answers as
/// to noise of the image, x by the covariance times J^T W v, spin and the air's errors likewise. Left out are products
/// with residuals, and what the spin's change does to the lift: a thousandth of it.
/// Source: Gauss-Newton's step, e.g. Bjorck, Numerical Methods for Least Squares Problems, 9.2.
std::vector<decltype(Number::grad)> time_response(const ShotFit& fit);

}  // namespace strobe::reduction
