// The independent renderer's ball: a rough sphere in front of a pinhole. Metres, x right and y up from the middle of
// the view in the plane of flight, z towards the lens. Plain values; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace strobe::studies::digitize {

struct FeltLook {
  double roughness = 0.4;  ///< Oren and Nayar's sigma [rad]
  double grain = 0.06;     ///< of the albedo, relative
  double seam = 0.15;      ///< darker
  double line_width_m = 0.003, line_contrast = 0.8, line_tilt_rad = 0.0;
  double fringe_px = 0.5;  ///< width over which fibres fade at the limb
  double hairs_px = 0.15;  ///< by which the limb wavers
  bool line = true;
  std::uint64_t texture = 1;
};

struct FeltBall {
  cv::Vec3d centre;
  double radius_m = 0.0325;
  double equator_rad = 0.0;
  double floor_m = -1e9;  ///< y of the surface that cuts it off
  std::array<double, 2> light{};
};

/// Light that the felt sends to the lens from where a ray meets the ball, over that of a white sheet that faces a lamp.
/// `normal`: of length 1, from the ball's centre.
double felt_light(const FeltLook& look, const FeltBall& ball, const std::array<cv::Vec3d, 2>& lamps,
                  const cv::Vec3d& normal, const cv::Vec3d& to_lens);

/// Of a sum of waves around the limb, px.
double limb_waver(const FeltLook& look, const FeltBall& ball, double angle_rad);

/// 0 to 1, smooth over a length of 1.
double value_noise(std::uint64_t seed, const cv::Vec3d& at);

}  // namespace strobe::studies::digitize
