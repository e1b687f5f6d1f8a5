// The covariance of a fitted outline: from the residuals of its sectors (sandwich estimator), which texture,
// shading and blur correlate along the outline, and what no residual shows, since all outlines of a
// photograph are off alike. Pure; thread-safe.
#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "host/digitize/outline/sector_offsets.hpp"

namespace strobe::digitize {

/// Centre x, y, radius, ovality cos, sin [local px].
inline constexpr int kOutlineParameters = 5;
using OutlineVector = cv::Vec<double, kOutlineParameters>;
using OutlineMatrix = cv::Matx<double, kOutlineParameters, kOutlineParameters>;

struct FittedSectors {
  const SectorOffsets& offsets;
  std::span<const OutlineVector> gradients;  ///< of the radius by the unknowns
  std::span<const double> residuals;         ///< px
  double sigma_px = 1.0;                     ///< sd of the blur
  double radius_px = 1.0;
  double depth_px = 0.0;  ///< how deep below the outline light was fitted
  bool cut_off = false;   ///< by the photograph's border, a quarter of the outline or more
};

struct OutlineSd {
  OutlineMatrix covariance;       ///< symmetric, positive semi-definite
  double shared_radius_px = 0.0;  ///< sd of what all outlines of a photograph are off alike: in it, too
};

/// `prior`: precision of what is known before; `rounding_sd`: of the photograph's light, by which numbers its
/// file has.
OutlineSd outline_covariance(const FittedSectors& sectors, const OutlineMatrix& prior, double rounding_sd);

}  // namespace strobe::digitize
