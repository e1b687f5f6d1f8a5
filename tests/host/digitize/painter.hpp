// A small painter of photographs with known truth, for tests of the digitizer's stages: shaded spheres that
// add up over a background, with a line, a seam, grain, blur and noise. It shares nothing with the
// simulator's renderer, so that the two judge each other. Deterministic by its seeds; no I/O; thread-safe;
// allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <vector>

#include "host/digitize/image/photograph.hpp"

namespace strobe::testing {

/// A lamp far away; its direction as seen from the ball: x right, y up, z to the camera.
struct PaintedLamp {
  cv::Vec3d towards{0.0, 0.0, 1.0};
  double strength = 1.0;
};

struct PaintedLine {
  double angle_rad = 0.0;  ///< counter-clockwise from right, y up
  double width_px = 10.0;
  double contrast = 0.6;  ///< share of the light that it takes
  double tilt_rad = 0.0;  ///< of its plane out of the line of sight: what is seen of it is left of angle_rad
  double edge_px = 1.0;   ///< softness of its sides
  double offset = 0.0;    ///< of its plane from the ball's middle, to the same side, radii
};

struct PaintedBall {
  cv::Point2d centre;  ///< image px: x = column, y = row
  double diameter_px = 0.0;
  double light = 0.5;  ///< that full light from one lamp would give, of the sensor's range
  std::vector<PaintedLamp> lamps{{}};
  double ambient = 0.05;  ///< light from everywhere, as a share of `light`
  double limb = 1.0;      ///< exponent of the cosine of incidence: 1 Lambert, 0 a disc of one brightness
  double grain = 0.0;     ///< relative sd of the texture
  double grain_px = 4.0;  ///< its size in the middle of the ball
  double fuzz_px = 0.0;   ///< sd of the outline's irregularity
  std::optional<PaintedLine> line;
  double seam_contrast = 0.0;  ///< of a tennis ball's seam, turned by `seed`
  double seam_width_px = 6.0;
  std::optional<double> floor_row;  ///< nothing of the ball is below: pressed flat on a surface
  std::uint64_t seed = 1;
};

struct Painting {
  int width = 640, height = 480;
  int flashes = 30;                   ///< over which the background's light adds up
  double background = 0.05;           ///< sum over all flashes, in the middle
  cv::Point2d background_slope_px{};  ///< relative, per px along x and down the rows
  std::optional<double> plate_row;    ///< below this row it is bright
  double plate = 0.7;
  std::vector<PaintedBall> balls;
  double blur_px = 0.8;        ///< sd of the lens's blur
  double vignetting = 0.0;     ///< loss of light in the corners
  double electrons = 20000.0;  ///< at the top of the sensor's range: shot noise; 0: none
  double read_noise = 1e-3;    ///< of the sensor's range
  int bits = 8;                ///< 8, 12 (numbers up to 4095 of 65535) or 16
  std::uint64_t seed = 1;      ///< of the noise
};

/// The photograph as loaded from a file of that depth.
digitize::Photograph paint(const Painting& painting);

/// A ball as it may look: lamps left and right in front of it, felt, seam and line are drawn at random.
PaintedBall random_ball(std::mt19937_64& random, cv::Point2d centre, double diameter_px);

/// The same look with another place, as the next flash shows it: turned by `turn_rad`.
PaintedBall next_image(const PaintedBall& ball, cv::Point2d centre, double turn_rad);

}  // namespace strobe::testing
