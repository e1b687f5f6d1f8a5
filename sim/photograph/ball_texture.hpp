// Texture of the ball's surface without its line: a map of the hemisphere that faces the camera, in the
// ball's own axes. The ball turns about z only, so it is always the same hemisphere. Made once for a
// photograph; then read-only and thread-safe.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/photograph/appearance.hpp"

namespace strobe::sim {

class BallTexture {
 public:
  /// `radius_px`: of the balls, by which holes in the outline are deep.
  BallTexture(const BallAppearance& appearance, double radius_px);

  /// Reflected share at the point with the direction (x, y, ·) from the ball's centre.
  float albedo(double x, double y) const { return lookup(albedo_, x, y); }

  /// Tilt of the surface there, to be added to its normal's x and y; zero but for dimples.
  Vec2 normal_tilt(double x, double y) const {
    if (tilt_x_.empty()) return {};
    return {lookup(tilt_x_, x, y), lookup(tilt_y_, x, y)};
  }
  bool has_relief() const { return !tilt_x_.empty(); }
  bool has_hair() const { return !hair_px_.empty(); }

  /// Distance of the outline from the sphere's, in that direction of the ball. [px]
  double hair_px(double angle_rad) const;

 private:
  void add_felt(const BallAppearance& appearance);
  void add_seams(const BallAppearance& appearance);
  void mark(const BallAppearance& appearance, double radius_px);
  void print(const BallAppearance& appearance);
  void dent(const BallAppearance& appearance);
  void add_hair(const BallAppearance& appearance);
  static float lookup(const cv::Mat& map, double x, double y);

  cv::Mat albedo_;  ///< CV_32FC1
  cv::Mat tilt_x_;
  cv::Mat tilt_y_;
  std::vector<float> hair_px_;
};

}  // namespace strobe::sim
