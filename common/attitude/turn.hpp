// Rodrigues' rotation by a vector [rad] of any length, and the left Jacobian J of SO(3) there: a turn by v +
// d is one by J·d after one by v, to the first order (Barfoot, State Estimation for Robotics, eq. 7.77).
// A value; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace strobe::attitude {

class Turn {
 public:
  explicit Turn(const Eigen::Vector3d& by) : by_(by) {
    const double square = by.squaredNorm();
    if (square < 1e-8) {
      sine_ = 1.0 - square / 6.0;
      versine_ = 0.5 - square / 24.0;
      rest_ = 1.0 / 6.0 - square / 120.0;
      return;
    }
    const double angle = std::sqrt(square), half = std::sin(0.5 * angle);
    sine_ = std::sin(angle) / angle;
    versine_ = 2.0 * half * half / square;
    rest_ = (1.0 - sine_) / square;
  }

  Eigen::Vector3d operator*(const Eigen::Vector3d& v) const {
    const Eigen::Vector3d across = by_.cross(v);
    return v + sine_ * across + versine_ * by_.cross(across);
  }
  Eigen::Vector3d transposed_jacobian(const Eigen::Vector3d& v) const {
    const Eigen::Vector3d across = by_.cross(v);
    return v - versine_ * across + rest_ * by_.cross(across);
  }

 private:
  Eigen::Vector3d by_;
  double sine_ = 1.0, versine_ = 0.5, rest_ = 1.0 / 6.0;  ///< of the angle, over its powers
};

}  // namespace strobe::attitude
