// Sensitivity of a readout to displacements of its measurements: finite differences of the reduction over
// every coordinate and time of one frame's airborne images. Deterministic; thread-safe; allocates.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/reduction/frame.hpp"
#include "sim/plan/displacement.hpp"
#include "sim/plan/readouts.hpp"

namespace strobe::sim {

/// Coordinates of an image that can be displaced, in the order of Displacement's members.
enum class Coordinate { x, y, diameter, equator, time };
inline constexpr std::size_t kCoordinateCount = 5;
using CoordinateMask = std::array<bool, kCoordinateCount>;

class Sensitivity {
 public:
  /// Of a frame with legs, of a camera that sees balls travel to the left if `mirrored`; coordinates that
  /// `wanted` leaves out count as if they could not be displaced. Differences are one-sided over 10 µm,
  /// 0.1 mrad and 1 µs: far above where the fit stops (1e-6 of a standard deviation) and so small that the
  /// readout is linear over them.
  Sensitivity(const reduction::Frame& frame, bool mirrored, const CoordinateMask& wanted);

  const reduction::Quantities& readout() const { return readout_; }

  /// By how much each number can change, to first order, when each image is displaced as `images` say, and
  /// each surface point as `surface` (its place only): the effect of the known part, and for the unknown part
  /// the worst case, the sum over all coordinates of |dR/dc|·within. As many as the frame has; no surface:
  /// the points stay.
  PerQuantity propagated(std::span<const BoundedDisplacement> images,
                         std::span<const BoundedDisplacement> surface = {}) const;

 private:
  using Derivatives = std::array<double, reduction::kQuantityCount>;  ///< per m, rad or s; NaN: number lost
  reduction::Quantities readout_;
  std::vector<std::array<Derivatives, kCoordinateCount>> images_;  ///< all zero for contact images
  std::vector<std::array<Derivatives, 2>> surface_;
};

}  // namespace strobe::sim
