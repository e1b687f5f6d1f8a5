// Depth from the images' diameters, and the frame as one that stays at one depth would have shown it.
// Part of the reduction, not of its interface. Thread-safe; allocates.
//
// With the lens at distance L a ball at height z above the calibrated plane is seen larger, and
// farther from the lens' foot, by m = 1/(1 - z/L). Diameters over both legs give dm/dt on either side of the
// bounce; where they reject a constant depth, centres and diameters are divided by m over that at the bounce,
// and what is left open of dm/dt joins the map errors.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {

/// How well a machine is aimed by eye.
inline constexpr double kAimSd_rad = radians(2.0);

/// A frame with a lens, as if each line were seen along the camera's axis: from the lens a ball aside is seen
/// from another side. Its ovals are undone in any such frame.
Frame seen_on_axis(Frame frame);

/// How fast the ball comes nearer, over its distance from the lens, before and after the bounce.
struct DepthFit {
  Eigen::Vector2d rate_per_s = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the rates
  std::array<double, 2> contact_s{};                     ///< touchdown, lift-off, in the observations' time
  double diameter_px = 0.0, diameter_sd_px = 0.0;        ///< at the bounce, as seen on the axis
  bool moves = false;                                    ///< a constant depth is rejected
};

/// Absent without a lens, or with fewer than three diameters in use.
std::optional<DepthFit> fit_depth(const Frame& frame, const ShotFit& fit);

/// All images as seen at the bounce's depth; the rates' errors join the map errors.
void put_at_one_depth(const DepthFit& depth, const ShotFit& fit, Frame& frame);

/// What is left open where a constant depth is not rejected, and is not corrected: by one sd of each of two
/// independent errors of the rates, which the diameters tell and, before, that machines are aimed along the
/// plane to kAimSd_rad.
std::array<ObservedMapError, 2> depth_doubt(const DepthFit& depth, const Frame& frame, const ShotFit& fit);

/// Velocities towards the camera and, with a calibrated scale, the height above its plane.
void add_depth(const DepthFit& depth, const Frame& frame, const ShotFit& fit, Spatial& into);

}  // namespace strobe::reduction
