#include "sim/rig/camera.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace strobe::sim {

Camera::Camera(const Scene& scene)
    : settings_(scene.camera),
      radius_m_(scene.ball.radius_m()),
      turn_rad_(scene.camera.roll_rad +
                (scene.camera.mirrored ? -scene.surface_angle_rad : scene.surface_angle_rad)),
      turn_cos_(std::cos(turn_rad_)),
      turn_sin_(std::sin(turn_rad_)),
      bend_pm2_(0.0) {
  const double w = settings_.half_width_m;
  const double h = 0.5 * settings_.height_m;
  if (settings_.distortion != 0.0) bend_pm2_ = settings_.distortion / (w * w + h * h);
  const reduction::PointPx foot = photograph({0.0, 0.0});
  foot_px_ = {foot.x, foot.y};
  if (settings_.turned())
    slant_ = Slant(settings_.swing_rad, settings_.tilt_rad, settings_.px_per_m * settings_.distance_m);
}

/// From the axis, x to the photograph's right. [m]
Camera::Point Camera::from_axis(double x_m, double y_m) const {
  return {settings_.mirrored ? -x_m : x_m, y_m - 0.5 * settings_.height_m};
}

/// Where a point is seen in the focused plane, through the lens.
Camera::Point Camera::seen(double x_m, double y_m, double off_plane_m) const {
  Point p = from_axis(x_m, y_m);
  if (settings_.distance_m > 0.0) {
    const double nearer = settings_.distance_m / (settings_.distance_m - off_plane_m);
    p = {nearer * p.x, nearer * p.y};
  }
  const double stretch = 1.0 + bend_pm2_ * (p.x * p.x + p.y * p.y);
  return {stretch * p.x, stretch * p.y};
}

reduction::PointPx Camera::photograph(const Point& p) const {
  const double y = p.y + 0.5 * settings_.height_m;
  const reduction::PointPx square{
      settings_.origin_x_px + settings_.px_per_m * (turn_cos_ * p.x - turn_sin_ * y),
      settings_.origin_y_px + settings_.px_per_m * (turn_sin_ * p.x + turn_cos_ * y)};
  if (slant_.is_none()) return square;
  const Eigen::Vector2d seen = foot_px_ + slant_.apply(Eigen::Vector2d(square.x, square.y) - foot_px_);
  return {seen.x(), seen.y()};
}

void Camera::slant(BallView& view) const {
  if (slant_.is_none()) return;
  const Eigen::Vector2d seen(view.centre_px.x, view.centre_px.y);
  const Eigen::Vector2d square = slant_.undo(seen - foot_px_);
  const Eigen::Vector2d line =
      slant_.jacobian(square) * Eigen::Vector2d(std::cos(view.equator_rad), std::sin(view.equator_rad));
  const Slant::Ellipse image =
      slant_.apply(Slant::Ellipse{square, view.along_px, view.across_px, view.axis_rad});
  view.centre_px = {foot_px_.x() + image.centre.x(), foot_px_.y() + image.centre.y()};
  view.along_px = image.along;
  view.across_px = image.across;
  view.axis_rad = image.axis_rad;
  view.equator_rad = std::atan2(line.y(), line.x());
}

double Camera::direction_seen(const Point& c, double depth_m, double angle_rad) const {
  const double ex = std::cos(angle_rad);
  const double ey = std::sin(angle_rad);
  const double u = c.x * ex + c.y * ey;
  const double tilt = std::atan2(u, depth_m);
  const double limb = std::asin(radius_m_ / std::hypot(depth_m, u));
  const auto image = [&](double psi) {
    const double share = 1.0 / (depth_m - radius_m_ * std::sin(psi));
    const double along = radius_m_ * std::cos(psi);
    return Point{(c.x + along * ex) * share, (c.y + along * ey) * share};
  };
  const Point a = image(tilt + limb);
  const Point b = image(std::numbers::pi + tilt - limb);
  return std::atan2(a.y - b.y, a.x - b.x);
}

void Camera::distort(BallView& view, Point& centre, double& angle_rad) const {
  const double square = bend_pm2_ * (centre.x * centre.x + centre.y * centre.y);
  const double area = view.along_px * view.across_px / (settings_.px_per_m * settings_.px_per_m);
  const double outwards = 1.0 + square + 3.0 * bend_pm2_ * area;
  const double along = std::cos(angle_rad - view.axis_rad) * (1.0 + 3.0 * square);
  const double across = std::sin(angle_rad - view.axis_rad) * (1.0 + square);
  angle_rad = view.axis_rad + std::atan2(across, along);
  view.along_px *= 1.0 + 3.0 * square;
  view.across_px *= 1.0 + square;
  centre = {outwards * centre.x, outwards * centre.y};
}

BallView Camera::view(double x_m, double y_m, double off_plane_m, double equator_rad) const {
  Point centre = from_axis(x_m, y_m);
  double angle = settings_.mirrored ? -equator_rad : equator_rad;
  BallView view;
  view.along_px = view.across_px = settings_.px_per_m * radius_m_;
  view.axis_rad = std::atan2(centre.y, centre.x);
  if (settings_.distance_m > 0.0) {
    const double depth = settings_.distance_m - off_plane_m;
    const double square = centre.x * centre.x + centre.y * centre.y;
    const double ray = square + depth * depth;
    const double sin_beta = radius_m_ / std::sqrt(ray);
    const double q = depth * depth / ray - sin_beta * sin_beta;
    const double scale_px = settings_.px_per_m * settings_.distance_m;
    angle = direction_seen(centre, depth, angle);
    view.along_px = scale_px * sin_beta * std::sqrt(1.0 - sin_beta * sin_beta) / q;
    view.across_px = scale_px * sin_beta / std::sqrt(q);
    const double nearer = settings_.distance_m * depth / (ray * q);  // sin·cos/q over hypot(X, Y)
    centre = {nearer * centre.x, nearer * centre.y};
  }
  if (bend_pm2_ != 0.0) distort(view, centre, angle);
  view.centre_px = photograph(centre);
  view.axis_rad += turn_rad_;
  view.equator_rad = angle + turn_rad_;
  slant(view);
  return view;
}

LineView Camera::line(double x_m, double y_m, double off_plane_m, const Eigen::Vector3d& normal,
                      double offset) const {
  Eigen::Vector3d v = Eigen::Vector3d::UnitZ();
  double limb = 0.0;
  const double side = settings_.mirrored ? -1.0 : 1.0;  // of the photograph's x
  if (settings_.distance_m > 0.0) {
    const Point centre = from_axis(x_m, y_m);
    const Eigen::Vector3d way(-side * centre.x, -centre.y, settings_.distance_m - off_plane_m);
    v = way.normalized();
    limb = radius_m_ / way.norm();
  }
  const double k = normal.dot(v);
  const Eigen::Vector3d middle = ((limb - k * offset) * v + (offset - k * limb) * normal) / (1.0 - k * k);
  // In the mirror what was to the right is to the left.
  const Eigen::Vector3d along = side * normal.cross(v).normalized();
  const Eigen::Vector3d half = std::sqrt(std::max(0.0, 1.0 - middle.squaredNorm())) * along;
  const auto seen = [&](const Eigen::Vector3d& p) {
    return project(x_m + radius_m_ * p.x(), y_m + radius_m_ * p.y(), off_plane_m + radius_m_ * p.z());
  };
  const reduction::PointPx a = seen(middle + half), b = seen(middle - half);
  const double direction_rad = std::atan2(a.y - b.y, a.x - b.x);
  const LineView view{modulo_pi(direction_rad), std::asin(std::clamp(-k, -1.0, 1.0))};
  // The normal is to the left of n × v.
  return std::cos(direction_rad - view.equator_rad) > 0.0 ? view : LineView{view.equator_rad, -view.tilt_rad};
}

double Camera::project_angle(double angle_rad) const {
  return (settings_.mirrored ? -angle_rad : angle_rad) + turn_rad_;
}

bool Camera::sees(double x_m, double y_m) const { return may_see(x_m) && y_m <= settings_.height_m; }

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
