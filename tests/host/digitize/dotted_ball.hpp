// A ray-traced ball with a pattern of dots: truth for attitudes. Shares nothing with the digitizer or the simulator.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/digitize/image/photograph.hpp"

namespace strobe::testing {

struct DottedBall {
  std::vector<Eigen::Vector3d> dots;  ///< unit directions, ball's axes
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Identity();
  double diameter_px = 100.0;
  double dot_radius_rad = 0.1;
  double dot_light = 0.25;                ///< share of the ball's that a dot sends back
  Eigen::Vector3d lamp{0.3, 0.5, 1.0};    ///< direction to it
  double blur_px = 0.7;                   ///< sd of the lens' blur
  double smear_px = 0.0;                  ///< by flight while it was lit, along x
  double noise = 0.01;                    ///< sd of a pixel, of white
  double distance_radii = 1e6;            ///< from the ball's centre to the lens
  Eigen::Vector2d off_px{0.0, 0.0};       ///< of the ball's middle from the picture's, x right, y up
  std::uint64_t seed = 1;
};

/// 1.3 diameters wide and high, 8 bits.
digitize::Photograph photograph_of(const DottedBall& ball);

/// Uniform over all attitudes (Shoemake 1992), from three numbers in 0 to 1.
Eigen::Matrix3d attitude_from(double a, double b, double c);

/// As many directions, the same for the same seed, at least `apart_rad` from each other: no symmetry.
std::vector<Eigen::Vector3d> drawn_pattern(int dots, double apart_rad, std::uint64_t seed);

}  // namespace strobe::testing
