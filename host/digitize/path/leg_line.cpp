#include "host/digitize/path/leg_line.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <set>

#include "common/geometry/line.hpp"
#include "host/digitize/core/eigen.hpp"

namespace strobe::digitize {
namespace {

// The bend of a leg at 5 m/s, g/(2 v²) = 0.2 per metre, for a ball of 65 mm; and some more.
constexpr double kMaxBendOfDiameter = 0.02;
constexpr double kLooseOfDiameter = 0.12;
constexpr double kInlier_sd = 4.0;
// Two centres closer than this give no direction.
constexpr double kMinStepOfDiameter = 0.1;

/// The members are not all at one place.
LegLine straight(std::span<const PathPoint> points, const std::vector<int>& members, double diameter_px) {
  std::vector<Eigen::Vector2d> centres;
  std::vector<double> weights;
  for (const int i : members) {
    const PathPoint& p = point_at(points, i);
    centres.push_back(to_eigen(p.at));
    weights.push_back(p.weight / variance_across(p, diameter_px));
  }
  const auto fitted = geometry::fit_line(centres, weights);
  assert(fitted.has_value());
  LegLine line;
  line.origin = to_point(fitted->origin());
  line.along = to_point(fitted->direction());
  return line;
}

/// The bent leg's least squares, off = a + b place + c place² with places in units of `scale_px`.
struct BentFit {
  double scale_px = 1.0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
};

BentFit bent_fit(std::span<const PathPoint> points, const std::vector<int>& members, double diameter_px,
                 const LegLine& line) {
  BentFit fit;
  for (const int i : members)
    fit.scale_px = std::max(fit.scale_px, std::abs(line.place(point_at(points, i).at)));
  for (const int i : members) {
    const PathPoint& p = point_at(points, i);
    const double s = line.place(p.at) / fit.scale_px, weight = p.weight / variance_across(p, diameter_px);
    const Eigen::Vector3d row(1.0, s, s * s);
    fit.normal += weight * row * row.transpose();
    fit.right += weight * line.off(p.at) * row;
  }
  return fit;
}

/// Moore-Penrose: members at two places only leave the bend open.
Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(symmetric);  // ascending
  const double least = 3.0 * std::numeric_limits<double>::epsilon() * axes.eigenvalues()[2];
  const Eigen::Vector3d inverses =
      axes.eigenvalues().unaryExpr([&](double value) { return value > least ? 1.0 / value : 0.0; });
  return axes.eigenvectors() * inverses.asDiagonal() * axes.eigenvectors().transpose();
}

/// Bends the line unless that is more than gravity explains; then says how well it is known.
void bend(std::span<const PathPoint> points, const std::vector<int>& members, double diameter_px,
          LegLine& line) {
  const BentFit fit = bent_fit(points, members, diameter_px, line);
  const Eigen::Matrix3d inverse = pseudo_inverse(fit.normal);
  const Eigen::Vector3d units(1.0, 1.0 / fit.scale_px, 1.0 / (fit.scale_px * fit.scale_px));
  const Eigen::Vector3d c = units.cwiseProduct(inverse * fit.right);
  if (!(std::abs(c[2]) <= kMaxBendOfDiameter / diameter_px)) return;
  line.covariance = units.asDiagonal() * inverse * units.asDiagonal();
  line.bend_per_px = c[2];
  line.origin += c[0] * cv::Point2d(-line.along.y, line.along.x);
  line.along = to_point(geometry::Rotation2d(std::atan(c[1])) * to_eigen(line.along));
}

std::vector<int> near_line(std::span<const PathPoint> points, std::span<const int> eligible,
                           const LegLine& line, double diameter_px) {
  std::vector<int> members;
  for (const int i : eligible) {
    const PathPoint& p = point_at(points, i);
    if (std::abs(line.off(p.at)) <= leg_tolerance(p, diameter_px, line.sd(p.at))) members.push_back(i);
  }
  return members;
}

LegLine through(const PathPoint& a, const PathPoint& b) {
  LegLine line;
  line.origin = 0.5 * (a.at + b.at);
  line.along = (b.at - a.at) / cv::norm(b.at - a.at);
  return line;
}

std::vector<int> loosely_near(std::span<const PathPoint> points, std::span<const int> eligible,
                              const LegLine& line, double diameter_px) {
  std::vector<int> members;
  for (const int i : eligible) {
    if (std::abs(line.off(point_at(points, i).at)) <= kLooseOfDiameter * diameter_px) members.push_back(i);
  }
  return members;
}

double spread(std::span<const PathPoint> points, const std::vector<int>& members) {
  double most = 0.0;
  for (const int i : members)
    most = std::max(most, cv::norm(point_at(points, i).at - point_at(points, members.front()).at));
  return most;
}

}  // namespace

double LegLine::off(cv::Point2d p) const {
  const double s = place(p);
  return along.cross(p - origin) - bend_per_px * s * s;
}

double LegLine::sd(cv::Point2d p) const {
  const double s = place(p);
  const Eigen::Vector3d row(1.0, s, s * s);
  return std::sqrt(std::max(0.0, row.dot(covariance * row)));
}

double leg_tolerance(const PathPoint& point, double diameter_px, double leg_sd_px) {
  const double sd = std::sqrt(variance_across(point, diameter_px) + leg_sd_px * leg_sd_px);
  return std::max(kInlier_sd * point.sd_px, std::min(kInlier_sd * sd, kLooseOfDiameter * diameter_px));
}

LegLine fit_leg_line(std::span<const PathPoint> points, std::vector<int> members, double diameter_px) {
  LegLine line = straight(points, members, diameter_px);
  if (members.size() >= 4) bend(points, members, diameter_px, line);
  for (const int i : members) line.weight += point_at(points, i).weight;
  line.members = std::move(members);
  return line;
}

std::vector<LegLine> leg_lines(std::span<const PathPoint> points, std::span<const int> eligible,
                               double diameter_px, std::size_t max_lines) {
  std::vector<LegLine> lines;
  std::set<std::vector<int>> known;
  const auto offer = [&](std::vector<int> members) {
    if (members.size() < 2 || spread(points, members) < kMinStepOfDiameter * diameter_px) return;
    if (!known.insert(members).second) return;
    lines.push_back(fit_leg_line(points, std::move(members), diameter_px));
  };
  for (std::size_t a = 0; a < eligible.size(); ++a) {
    for (std::size_t b = a + 1; b < eligible.size(); ++b) {
      const PathPoint& pa = point_at(points, eligible[a]);
      const PathPoint& pb = point_at(points, eligible[b]);
      if (cv::norm(pa.at - pb.at) < kMinStepOfDiameter * diameter_px) continue;
      const LegLine pair = through(pa, pb);
      offer(near_line(points, eligible, pair, diameter_px));
      std::vector<int> members = loosely_near(points, eligible, pair, diameter_px);
      for (int round = 0; round < 3 && members.size() >= 4; ++round)
        members = near_line(points, eligible, fit_leg_line(points, members, diameter_px), diameter_px);
      offer(std::move(members));
    }
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const LegLine& x, const LegLine& y) { return x.weight > y.weight; });
  if (lines.size() > max_lines) lines.resize(max_lines);
  return lines;
}

}  // namespace strobe::digitize
