// The offset of an outline in one sector. The sector's profile is fitted by a linear background, a blurred
// step and a blurred square root (edge_profile.hpp), and the same for neighbouring outlines that cross it.
// How step, root and slopes share the rise is known beforehand within what a lit sphere can show, which
// counts where noise and texture leave it open. The residuals of these linear terms give the outline's offset
// and the change of the blur (variable projection, Golub and Pereyra 1973, in Kaufman's form). Deterministic;
// thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/outline/edge_profile.hpp"
#include "host/digitize/outline/sector_samples.hpp"

namespace strobe::digitize {

/// The edge in one sector.
struct SectorEdge {
  bool usable = false;           ///< there is an edge, brighter inside
  double offset_px = 0.0;        ///< of the true outline, outwards
  double sd_px = 0.0;            ///< of the offset, from the pixels' scatter
  double sigma_change = 0.0;     ///< suggested change of the blur, times sigma_weight
  double sigma_weight = 0.0;     ///< inverse variance of that change
  bool no_edge = false;          ///< intensity does not rise here though an edge would be visible
  double step = 0.0;             ///< rise of intensity at the limb
  double rise = 0.0;             ///< likewise from there to the window's end
  double rounding = 0.0;         ///< likewise by its curvature over a blur's width
  double offset_by_sigma = 0.0;  ///< d(offset)/d(blur)
};

/// The profiles that fit_sector() needs for an outline of that radius and blur.
ProfileTable sector_profiles(const SectorSamples& samples, double radius_px, double sigma_px);

/// `coarse`: the shape may still be off by more than a px.
SectorEdge fit_sector(const SectorSamples& samples, int index, const OutlineShape& shape,
                      std::span<const OutlineShape> neighbours, const ProfileTable& profiles, double sigma_px,
                      bool coarse);

}  // namespace strobe::digitize
