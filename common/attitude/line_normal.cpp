#include "common/attitude/line_normal.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace strobe::attitude {
namespace {

Eigen::Vector3d unit_sight(const Eigen::Vector2d& sight) {
  return Eigen::Vector3d(sight.x(), sight.y(), 1.0).normalized();
}

}  // namespace

LinePlane line_plane(double angle_rad, double tilt_rad, const Eigen::Vector2d& sight) {
  const Eigen::Vector3d to_lens = unit_sight(sight);
  const Eigen::Vector2d seen(std::cos(angle_rad), std::sin(angle_rad));
  // With c·(sight, 1) = 0 and c_xy - sight·c_z along `seen`.
  const double depth = -sight.dot(seen) / (1.0 + sight.squaredNorm());
  const Eigen::Vector3d chord =
      Eigen::Vector3d(seen.x() + sight.x() * depth, seen.y() + sight.y() * depth, depth).normalized();
  const Eigen::Vector3d left = to_lens.cross(chord);
  const double c = std::cos(tilt_rad), s = std::sin(tilt_rad);
  return {c * left - s * to_lens, chord, -s * left - c * to_lens};
}

double line_angle_rad(const Eigen::Vector3d& normal, const Eigen::Vector2d& sight) {
  const Eigen::Vector3d chord = normal.cross(unit_sight(sight));
  const Eigen::Vector2d seen = chord.head<2>() - sight * chord.z();
  return std::atan2(seen.y(), seen.x());
}

}  // namespace strobe::attitude
