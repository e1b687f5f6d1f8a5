// The ball's surface but for its line: a map of the half that is turned to the camera, in the ball's own
// axes. The ball turns about z only, so that it is always the same half. Made once for a photograph; then
// read-only and thread-safe.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/photograph/look.hpp"

namespace strobe::sim {

class Skin {
 public:
  explicit Skin(const BallLook& look);

  /// Reflected share at the point with the direction (x, y, ·) from the ball's centre.
  float albedo(double x, double y) const { return lookup(albedo_, x, y); }

  /// How the surface leans there, to be added to its normal's x and y; zero but for dimples.
  Vec2 lean(double x, double y) const {
    if (lean_x_.empty()) return {};
    return {lookup(lean_x_, x, y), lookup(lean_y_, x, y)};
  }
  bool leans() const { return !lean_x_.empty(); }

  /// By how much the outline lies outside of the sphere's in that direction of the ball. [px]
  double hair_px(double angle_rad) const;

 private:
  void grow_felt(const BallLook& look);
  void sew(const BallLook& look);
  void print(const BallLook& look);
  void dent(const BallLook& look);
  void comb(const BallLook& look);
  static float lookup(const cv::Mat& map, double x, double y);

  cv::Mat albedo_;  ///< CV_32FC1
  cv::Mat lean_x_;
  cv::Mat lean_y_;
  std::vector<float> hair_px_;
};

}  // namespace strobe::sim
