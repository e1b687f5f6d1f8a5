// Appearance of one photograph: the scene's settings, with random values for those that they leave open.
// Plain values; thread-safe.
#pragma once

#include <array>
#include <cstdint>

#include "sim/photograph/optics.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct BallAppearance {
  BallSurface surface = BallSurface::felt;
  bool line = true;
  double line_width_m = 0.0025;
  double line_contrast = 0.8;
  double line_steepness = 4.0;  ///< of its profile exp(-ln2·|2x/width|^steepness); 2: a Gaussian
  double line_tilt_rad = 0.0;   ///< the line's plane against the line of sight
  double grain = 0.05;
  double seam_contrast = 0.2;
  double logo_contrast = 0.5;
  double fuzz_px = 0.2;       ///< half width over which the limb fades
  double hair_px = 0.1;       ///< sd of the outline's irregularity
  double falloff = 0.9;       ///< exponent of the cosine of incidence: 1 is Lambert's
  double sheen = 0.15;        ///< share of light that the felt's hair adds towards the limb
  double shine = 0.0;         ///< height of the reflected lamp
  std::uint64_t texture = 1;  ///< seed of grain, seams, logo and hair
};

struct LampAppearance {
  Vec3 place;  ///< axis coordinates
  double power = 1.0;
  double radius_m = 0.05;
};

struct BackgroundAppearance {
  double wall = 0.05;
  double wall_ramp = 0.3;  ///< from one side to the other, relative
  double plate_brightness = 1.0;
  double plate_thickness_m = 0.015;
  double plate_half_length_m = 0.35;
  std::uint64_t clutter = 1;  ///< seed of the objects in the background
};

struct Appearance {
  BallAppearance ball;
  std::array<LampAppearance, 2> lamps;  ///< A to the left, B to the right
  BackgroundAppearance background;
  double blur_px = 0.8;
  double vignetting = 0.1;
  std::uint64_t noise = 1;  ///< seed of the sensor's noise and of the flashes' power
};

/// The appearance of the `shot`-th photograph (1-based). Every draw is taken even if the scene gives the
/// value, so that setting one key does not change another.
Appearance draw_appearance(const Scene& scene, std::uint64_t seed, int shot);

}  // namespace strobe::sim
