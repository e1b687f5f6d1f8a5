// The covariance of a fitted outline, from the residuals of its sectors, which texture and shading correlate (sandwich
// estimator with Bartlett's window along the outline, Newey and West 1987). Deterministic; thread-safe; allocates.
#pragma once

#include <span>

#include "host/digitize/outline/outline_fit.hpp"
#include "host/digitize/outline/sector_offsets.hpp"

namespace strobe::digitize {

struct FittedSectors {
  const SectorOffsets& offsets;
  std::span<const OutlineVector> gradients;  ///< of the radius by the unknowns
  std::span<const double> residuals;         ///< px
};

/// `prior`: precision of what is known before.
OutlineMatrix outline_covariance(const FittedSectors& sectors, const OutlineMatrix& prior, double sigma_px,
                                 double radius_px);

}  // namespace strobe::digitize
