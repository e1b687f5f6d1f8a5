#include "sim/rig/slant.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace strobe::sim {

namespace {

Eigen::Vector2d divided(const Eigen::Matrix3d& map, const Eigen::Vector2d& p) {
  return (map * p.homogeneous()).hnormalized();
}

}  // namespace

Slant::Slant(double swing_rad, double tilt_rad, double distance_px)
    : none_(swing_rad == 0.0 && tilt_rad == 0.0) {
  const double ca = std::cos(swing_rad), sa = std::sin(swing_rad);
  const double cb = std::cos(tilt_rad), sb = std::sin(tilt_rad);
  Eigen::Matrix3d right, up;
  right << ca, 0.0, -sa, 0.0, 1.0, 0.0, sa, 0.0, ca;
  up << 1.0, 0.0, 0.0, 0.0, cb, -sb, 0.0, sb, cb;
  rotation_ = up * right;
  const Eigen::Vector3d lens(distance_px, distance_px, 1.0);
  turning_ = lens.asDiagonal() * rotation_ * lens.cwiseInverse().asDiagonal();
  shift_px_ = -divided(turning_, Eigen::Vector2d::Zero());
  turning_.topRows<2>() += shift_px_ * turning_.row(2);
  undoing_ = turning_.inverse();
}

Eigen::Vector2d Slant::apply(const Eigen::Vector2d& square_px) const {
  return none_ ? square_px : divided(turning_, square_px);
}

Eigen::Vector2d Slant::undo(const Eigen::Vector2d& seen_px) const {
  return none_ ? seen_px : divided(undoing_, seen_px);
}

Eigen::Matrix2d Slant::jacobian(const Eigen::Vector2d& square_px) const {
  const Eigen::Vector3d h = turning_ * square_px.homogeneous();
  return (turning_.topLeftCorner<2, 2>() - h.hnormalized() * turning_.bottomLeftCorner<1, 2>()) / h.z();
}

Slant::Ellipse Slant::apply(const Ellipse& square) const {
  if (none_) return square;
  // The matrix C of the conic p'·C·p = 0 becomes C of the undone p.
  const double c = std::cos(square.axis_rad), s = std::sin(square.axis_rad);
  Eigen::Matrix2d axes;
  axes << c, -s, s, c;
  const Eigen::Vector2d inverse_squares(1.0 / (square.along * square.along),
                                        1.0 / (square.across * square.across));
  const Eigen::Matrix2d quadratic = axes * inverse_squares.asDiagonal() * axes.transpose();
  Eigen::Matrix3d conic;
  conic.topLeftCorner<2, 2>() = quadratic;
  conic.topRightCorner<2, 1>() = -quadratic * square.centre;
  conic.bottomLeftCorner<1, 2>() = conic.topRightCorner<2, 1>().transpose();
  conic(2, 2) = square.centre.dot(quadratic * square.centre) - 1.0;
  const Eigen::Matrix3d seen = undoing_.transpose() * conic * undoing_;
  const Eigen::Matrix2d form = seen.topLeftCorner<2, 2>();
  const Eigen::Vector2d side = seen.topRightCorner<2, 1>();
  Ellipse image;
  image.centre = -form.inverse() * side;
  const double level = -(seen(2, 2) + side.dot(image.centre));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solved(form);  // ascending: the longer axis first
  image.along = std::sqrt(level / solved.eigenvalues()[0]);
  image.across = std::sqrt(level / solved.eigenvalues()[1]);
  image.axis_rad = std::atan2(solved.eigenvectors()(1, 0), solved.eigenvectors()(0, 0));
  return image;
}

}  // namespace strobe::sim
