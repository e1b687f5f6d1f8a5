// Whether the surface points lie on one line, and whether the images in contact lie where that line has them.
// Part of the reduction, not of its interface. Thread-safe; allocates only where they do not.
#pragma once

#include <optional>

#include "common/reduction/propagate.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// A frame whose surface points agree, and how it was got.
struct ConsistentSurface {
  Frame frame;  ///< without the points left out, or with a larger surface_sd_px
  Flag flag = Flag::outlier_surface_point;
};

/// Leave-one-out: is some point further from the line through the others than chance explains? One clean
/// photograph in a thousand fails. Returns nullopt if none is. Otherwise
///  - of four or more points the fewest whose lack lets the rest agree are left out (every subset of up to
///    twelve points is tried, so that two wrong points cannot hide each other): outlier_surface_point;
///  - where other subsets agree as well, as of any three points, none can be singled out: all are kept and
///  their
///    standard deviation is scaled to their scatter (Birge's ratio): surface_suspect.
/// Points whose noise is neither stated nor that of the centres have nothing to be held against: nullopt.
std::optional<ConsistentSurface> consistent_surface(const Frame& frame, const ShotFit& fit);

/// Whether an image in contact contradicts the line: its centre more than a radius above it or beneath it, or
/// its time before the touchdown or after the lift-off that the legs' paths have with it. All that two
/// points, which any line fits, can be held against; a line too high by less than the gap below the last
/// airborne image passes. One clean photograph in a thousand fails.
bool contact_contradicts_surface(const ShotFit& fit);

}  // namespace strobe::reduction
