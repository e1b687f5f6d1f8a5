#include "host/digitize/path/flight_curve.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace strobe::digitize {
namespace {

// Across one diameter of travel the scale changes by up to about a tenth where the ball flies steeply towards the
// camera; a camera held askew by some degrees makes a term of the same size.
constexpr double kPerspectiveSd = 0.1;
// Where the curve's own height is worth less than this share of a height beside it, it turns back over itself.
constexpr double kMinUniqueness = 0.2;
// The weight of a prior that leaves a term out.
constexpr double kLeftOut = 1e18;
constexpr double kMaxUpwards_sd = 3.0;
constexpr int kReweightings = 3;

}  // namespace

FlightCurve::Terms FlightCurve::terms(cv::Point2d p) const {
  const double u = (p.x - origin_.x) / unit_px_, v = (p.y - origin_.y) / unit_px_;
  Terms t;
  t << 1.0, u, u * u, u * v, v * v;
  return t;
}

/// Of v - terms·value.
double FlightCurve::gradient(cv::Point2d p) const {
  const double u = (p.x - origin_.x) / unit_px_, v = (p.y - origin_.y) / unit_px_;
  return std::hypot(value_[1] + 2.0 * value_[2] * u + value_[3] * v,
                    1.0 - value_[3] * u - 2.0 * value_[4] * v);
}

double FlightCurve::off(cv::Point2d p) const {
  const double v = (p.y - origin_.y) / unit_px_;
  return unit_px_ * (v - terms(p).dot(value_)) / gradient(p);
}

double FlightCurve::sd(cv::Point2d p) const {
  const Terms t = terms(p);
  return unit_px_ * std::sqrt(std::max(0.0, t.dot(covariance_ * t))) / gradient(p);
}

std::optional<double> FlightCurve::height(double x) const {
  const double u = (x - origin_.x) / unit_px_;
  const double flat = value_[0] + value_[1] * u + value_[2] * u * u;
  const double linear = 1.0 - value_[3] * u, square = value_[4];
  // The root that becomes flat / linear without perspective.
  const double under = linear * linear - 4.0 * square * flat;
  if (!(linear > 0.0) || !(under > 0.0)) return std::nullopt;
  return origin_.y + unit_px_ * 2.0 * flat / (linear + std::sqrt(under));
}

std::optional<double> FlightCurve::slope(double x) const {
  const auto y = height(x);
  if (!y) return std::nullopt;
  const double u = (x - origin_.x) / unit_px_, v = (*y - origin_.y) / unit_px_;
  return (value_[1] + 2.0 * value_[2] * u + value_[3] * v) / (1.0 - value_[3] * u - 2.0 * value_[4] * v);
}

bool FlightCurve::solve(std::span<const PathPoint> points, std::span<const int> members, int shape) {
  using Matrix = Eigen::Matrix<double, 5, 5>;
  Matrix normal = Matrix::Zero();
  normal(3, 3) = normal(4, 4) = 1.0 / (kPerspectiveSd * kPerspectiveSd);
  for (int k = shape; k < 5; ++k) normal(k, k) = kLeftOut;
  Terms right = Terms::Zero();
  for (const int i : members) {
    const PathPoint& p = point_at(points, i);
    const double sd = std::sqrt(variance_across(p, unit_px_)) / unit_px_ * gradient(p.at);
    const Terms row = terms(p.at);
    normal += row * row.transpose() / (sd * sd);
    right += row * ((p.at.y - origin_.y) / unit_px_ / (sd * sd));
  }
  const Eigen::LDLT<Matrix> solver(normal);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
  value_ = solver.solve(right);
  covariance_ = solver.solve(Matrix::Identity());
  return value_.allFinite() && covariance_.allFinite();
}

bool FlightCurve::is_flight(std::span<const PathPoint> points, std::span<const int> members) const {
  if (value_[2] > kMaxUpwards_sd * std::sqrt(covariance_(2, 2))) return false;
  return std::ranges::all_of(members, [&](int i) {
    const cv::Point2d p = point_at(points, i).at;
    const double u = (p.x - origin_.x) / unit_px_, v = (p.y - origin_.y) / unit_px_;
    return 1.0 - value_[3] * u - 2.0 * value_[4] * v > kMinUniqueness;
  });
}

std::optional<FlightCurve> FlightCurve::fit(std::span<const PathPoint> points, std::span<const int> members,
                                            double diameter_px, Shape shape) {
  FlightCurve curve;
  curve.unit_px_ = diameter_px;
  for (const int i : members) curve.origin_ += point_at(points, i).at / static_cast<double>(members.size());
  for (int round = 0; round < kReweightings; ++round)
    if (!curve.solve(points, members, static_cast<int>(shape))) return std::nullopt;
  if (!curve.is_flight(points, members)) return std::nullopt;
  return curve;
}

}  // namespace strobe::digitize
