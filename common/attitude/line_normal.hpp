// A line drawn around a ball as a camera sees it, and the plane that it lies in. Camera axes: x right, y up,
// z towards the lens. Plain values and pure functions; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>

namespace strobe::attitude {

/// What is measured of one image's line. The plane (angle + pi, -tilt) is the same.
struct LineReading {
  double time_s = 0.0;
  double angle_rad = 0.0;  ///< of the chord between the line's ends, on the photograph, counter-clockwise
  double tilt_rad = 0.0;   ///< of its plane out of the line of sight, -pi/2 to pi/2
  double angle_sd_rad = 0.0, tilt_sd_rad = 0.0;  ///< > 0
  double correlation = 0.0;                      ///< of the two, -1 to 1
  double time_sd_s = 0.0;
  /// From the ball to the lens over the distance to it along z: 0 for a lens far away.
  Eigen::Vector2d sight = Eigen::Vector2d::Zero();
};

/// The line's plane, in camera axes: its normal (or the opposite one, which is the same plane) and, all unit
/// vectors at right angles, the chord and the direction in which the normal moves as the tilt grows.
struct LinePlane {
  Eigen::Vector3d normal, chord, by_tilt;
};

/// A displacement d of a point of the ball is seen as d_xy - sight·d_z (the lens magnifies what comes
/// nearer): the chord stands on the line of sight and is seen at that angle. The normal is cos(tilt)·(sight x
/// chord) - sin(tilt)·sight.
LinePlane line_plane(double angle_rad, double tilt_rad, const Eigen::Vector2d& sight);

/// The angle at which the line of a plane is seen, modulo pi; of a ring around the line of sight any.
double line_angle_rad(const Eigen::Vector3d& normal, const Eigen::Vector2d& sight);

}  // namespace strobe::attitude
