// The offsets of an outline's sectors and how much each counts in its fit: robust weights, and shadow.
// Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/outline/sector_fit.hpp"

namespace strobe::digitize {

/// By sector, around the outline.
struct SectorOffsets {
  std::vector<SectorEdge> edges;
  std::vector<double> weight;       ///< 1/px²
  std::vector<double> robust;       ///< Tukey's weight, 0 to 1
  std::vector<double> sensitivity;  ///< 1/px², of the fit to a sector's offset (Tukey's psi')
  std::vector<double> common_sd;    ///< px, of the error that adjacent sectors share
  bool half_lit = false;            ///< a fifth of the outline or more lies in shadow
  double extra_variance = 0.0;      ///< beyond the sectors' own
};

/// Weights for these residuals: Tukey's, with the variance beyond the sectors' own that the residuals show.
void reweight(SectorOffsets& offsets, std::span<const double> residuals);

/// Where most sectors around have no edge the limb is in shadow, and a single edge belongs to something
/// else. Next to it, and on a half-lit ball as far as the light is oblique, the limb fades into the
/// terminator, which lies further inside: those sectors share an error.
void downweight_shadow(SectorOffsets& offsets, double sigma_px);

}  // namespace strobe::digitize
