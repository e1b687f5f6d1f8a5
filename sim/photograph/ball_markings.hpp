// What is sewn, moulded or printed all over a kind of ball, apart from a drawn line: where it is, by
// direction from the ball's centre in axes of its own. Plain geometry; read-only and thread-safe once made.
#pragma once

#include <vector>

#include "sim/photograph/appearance.hpp"

namespace strobe::sim {

class BallMarkings {
 public:
  explicit BallMarkings(BallSurface surface);

  /// How much of it is at the end of a unit vector: 0 none, 1 all. Zero of felt, whose seams are a texture's.
  double ink(const Vec3& direction) const;

  /// Cosine of the angle to the opening of the hole there, by which the outline falls back; 1: no hole.
  double edge_beyond(const Vec3& on_outline, const Vec3& to_lens) const;

 private:
  double stitches(const Vec3& p) const;
  double panels(const Vec3& p) const;
  double spots(const Vec3& p) const;

  BallSurface surface_;
  std::vector<Vec3> places_;  ///< the seam's points, the panels' or the spots' middles
};

/// The seam of tennis balls and baseballs: the curve of two dumb-bells, x = a cos t + b cos 3t, y = a sin t -
/// b sin 3t, z = 2 sqrt(ab) sin 2t, on the sphere where a + b = 1.
Vec3 seam_point(double t_rad);

}  // namespace strobe::sim
