// The ball's surface but for its line: a map of the half that is turned to the camera, in the ball's own
// axes. The ball turns about z only, so that it is always the same half. Made once for a photograph; then
// read-only and thread-safe.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/photograph/appearance.hpp"

namespace strobe::sim {

class BallTexture {
 public:
  explicit BallTexture(const BallAppearance& look);

  /// Reflected share at the point with the direction (x, y, ·) from the ball's centre.
  float albedo(double x, double y) const { return lookup(albedo_, x, y); }

  /// How the surface has_relief there, to be added to its normal's x and y; zero but for dimples.
  Vec2 normal_tilt(double x, double y) const {
    if (tilt_x_.empty()) return {};
    return {lookup(tilt_x_, x, y), lookup(tilt_y_, x, y)};
  }
  bool has_relief() const { return !tilt_x_.empty(); }

  /// By how much the outline lies outside of the sphere's in that direction of the ball. [px]
  double hair_px(double angle_rad) const;

 private:
  void add_felt(const BallAppearance& look);
  void add_seams(const BallAppearance& look);
  void print(const BallAppearance& look);
  void dent(const BallAppearance& look);
  void add_hair(const BallAppearance& look);
  static float lookup(const cv::Mat& map, double x, double y);

  cv::Mat albedo_;  ///< CV_32FC1
  cv::Mat tilt_x_;
  cv::Mat tilt_y_;
  std::vector<float> hair_px_;
};

}  // namespace strobe::sim
