// What the photograph says of the third dimension, and the frame as one that moves in the plane would have
// shown it, so that the planar fit is right for a ball whose spin's axis is tilted or that comes nearer.
// Part of the reduction, not of its interface. Thread-safe; allocates.
//
// Spin: where a leg's tilts reject an axis along the camera's, the spin vector is fitted to the planes of the
// drawn line (common/attitude/line_spin.hpp), and each equator is replaced by the angle that the spin about
// the camera's axis alone would have turned it to, with residual and sd in the proportion that gives the
// planar spin the variance of omega_z. What the reduction knows of friction, lift and half turns then holds
// for omega_z.
#pragma once

#include <array>
#include <optional>

#include "common/attitude/line_spin.hpp"
#include "common/reduction/depth_fit.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Whether a frame holds anything of it.
bool tells_third_dimension(const Frame& frame);

struct SpatialFit {
  /// Camera axes; index: incoming, rebound. One of both where the leg tells: a spin vector, or that the axis
  /// is the camera's but for what `planar` says.
  std::array<std::optional<attitude::LineSpin>, 2> spin;
  std::array<std::optional<attitude::PlanarTest>, 2> planar;
  std::optional<DepthFit> depth;
  FlagSet flags;               ///< axis_tilted, out_of_plane, spin_aliased
  std::optional<Frame> frame;  ///< to be reduced instead; absent: the frame as it is
};

/// `fit`: the planar one of the same frame, which found its legs.
SpatialFit fit_spatial(const Frame& frame, const ShotFit& fit);

/// Fills Readout::spatial, and sets spin_aliased where another spin vector is possible. `fit`: that of the
/// readout.
void add_spatial(const SpatialFit& spatial, const Frame& frame, const ShotFit& fit, Readout& readout);

}  // namespace strobe::reduction
