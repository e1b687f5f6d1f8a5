// The light that a ball sends to the camera.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/photograph/appearance.hpp"
#include "sim/photograph/ball_texture.hpp"
#include "sim/photograph/lit_balls.hpp"

namespace strobe::sim {

/// How much light a ball under two lamps sends along each pixel's rays. Made once for a photograph; read-only
/// and thread-safe after that.
///
/// A ball's image is what each ray meets: the sphere (X, Y, z; radius R), its normal n there, and for each
/// lamp in direction l at distance d the light (d0/d)²·[max(0, n·l)^falloff + sheen·(1 - n·v)²·sqrt(max(0,
/// n·l))] (felt's hair catches light towards the limb), times the skin's albedo and the line's darkness. Rays
/// that meet the sphere below the surface meet the plate instead. Pixels on the outline and on the flat side
/// are the mean of kGrid² rays, each with a coverage that falls over its own width.
class BallLight {
 public:
  BallLight(const Scene& scene, const Appearance& appearance);

  /// Adds the ball to the rows [first, end) of `light` (CV_32FC1) and takes from it the background that the
  /// ball hid: the share `hidden` of `behind`, of the same size as `light`. The lightest felt under both
  /// lamps gives 1.
  void add(const LitBall& ball, const cv::Mat& behind, double hidden, int first, int end,
           cv::Mat& light) const;

 private:
  struct Sample {
    double coverage = 0.0;
    double light = 0.0;
  };
  struct Placed;  ///< a ball with what is the same for all of its pixels

  Placed place(const LitBall& ball) const;
  Sample sample(const Placed& ball, double column, double row, double width_px) const;
  Sample pixel(const Placed& ball, int column, int row) const;
  double shade(const Placed& ball, const Vec3& normal, const Vec3& to_lens) const;
  double line_darkness(const Vec3& on_ball) const;
  double lamp_light(const Vec3& normal, const Vec3& to_lamp, double towards_lens, const Vec3& to_lens) const;

  Optics optics_;
  Appearance appearance_;
  BallTexture texture_;
  double radius_m_;
  double level_ = 1.0;  ///< over the light of the lightest felt
};

}  // namespace strobe::sim
