// Texture of the ball's surface without its line, in the ball's own axes: a map of the hemisphere that faces
// the camera, which is always the same while the ball turns about z only; otherwise six more, of the sides of
// a cube around it. Made once for a photograph; then read-only and thread-safe.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/photograph/appearance.hpp"

namespace strobe::sim {

class BallTexture {
 public:
  /// `radius_px`: of the balls, by which holes in the outline are deep. `all_around`: for balls that turn
  /// about another axis than z, whose outline is that of the hemisphere nevertheless.
  BallTexture(const BallAppearance& appearance, double radius_px, bool all_around);

  /// Reflected share at the point with the direction (x, y, ·) from the ball's centre.
  float albedo(double x, double y) const { return lookup(albedo_, x, y); }

  /// Of any direction, of length 1; all around only, as the next.
  double albedo(const Vec3& direction) const;
  /// To be added to the surface's normal there.
  Vec3 normal_tilt(const Vec3& direction) const;

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
  void cover(const BallAppearance& appearance);
  void dent(const BallAppearance& appearance);
  void add_hair(const BallAppearance& appearance);
  static float lookup(const cv::Mat& map, double x, double y);

  cv::Mat albedo_;                ///< CV_32FC1
  std::array<cv::Mat, 6> sides_;  ///< likewise
  std::vector<Vec3> dimples_;     ///< their middles
  cv::Mat tilt_x_;
  cv::Mat tilt_y_;
  std::vector<float> hair_px_;
};

}  // namespace strobe::sim
