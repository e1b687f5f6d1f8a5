#include "host/digitize/path/leg_line.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "common/geometry/line.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/flight_legs.hpp"

namespace strobe::digitize {
namespace {

// The bend of a leg at 5 m/s, g/(2 v²) = 0.2 per metre, for a ball of 65 mm; and some more.
constexpr double kMaxBendOfDiameter = 0.02;

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

/// Through points[members], at least 2 at different places; bent from 4 on.
LegLine fit_leg_line(std::span<const PathPoint> points, std::vector<int> members, double diameter_px) {
  LegLine line = straight(points, members, diameter_px);
  if (members.size() >= 4) bend(points, members, diameter_px, line);
  for (const int i : members) line.weight += point_at(points, i).weight;
  line.members = std::move(members);
  return line;
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
    if (std::abs(line.off(point_at(points, i).at)) <= kBandOfDiameter * diameter_px) members.push_back(i);
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
  return std::max(kFarthest_sd * point.sd_px, std::min(kFarthest_sd * sd, kBandOfDiameter * diameter_px));
}

std::vector<LegLine> leg_lines(std::span<const PathPoint> points, std::span<const int> eligible,
                               double diameter_px, std::size_t max_lines) {
  std::vector<LegLine> lines;
  std::set<std::vector<int>> known;
  const auto offer = [&](std::vector<int> members) {
    if (members.size() < 2 || spread(points, members) < kSamePlaceOfDiameter * diameter_px) return;
    if (!known.insert(members).second) return;
    lines.push_back(fit_leg_line(points, std::move(members), diameter_px));
  };
  for (std::size_t a = 0; a < eligible.size(); ++a) {
    for (std::size_t b = a + 1; b < eligible.size(); ++b) {
      const PathPoint& pa = point_at(points, eligible[a]);
      const PathPoint& pb = point_at(points, eligible[b]);
      if (cv::norm(pa.at - pb.at) < kSamePlaceOfDiameter * diameter_px) continue;
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

namespace {

constexpr double kLegCost = 0.5;
constexpr double kLegCostBlind = 1.2;
// Without a surface one photograph in ten may have a second leg of what is no ball. A line at random meets
// the first leg's within a contact of its end in one of six photographs (18 diameters wide), begins within as
// much from there in one of six, and leads upwards in one of two.
constexpr double kMaxLog10SecondLegs = -1.0;
constexpr double kMeetByChance = 1.0 / 72.0;

class LegPair {
 public:
  LegPair(std::span<const PathPoint> points, std::span<const int> airborne, const PathContext& context)
      : points_(points),
        airborne_(airborne),
        context_(context),
        d_(context.diameter_px),
        share_per_px_(share_of_view_per_px(points, airborne, d_)) {}

  std::vector<LegLine> run(std::span<const LegLine> lines) const {
    if (lines.empty()) return {};
    double best = lines.front().weight;
    const LegLine* one = &lines.front();
    const LegLine* two = nullptr;
    const double cost = leg_cost(context_);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t j = i + 1; j < lines.size(); ++j) {
        if (lines[i].weight + lines[j].weight - cost <= best) break;
        const double weight = union_weight(lines[i], lines[j]) - cost;
        if (weight <= best || !belong_together(lines[i], lines[j])) continue;
        best = weight;
        one = &lines[i];
        two = &lines[j];
      }
    }
    return two == nullptr ? std::vector{*one} : std::vector{*one, *two};
  }

 private:
  bool belong_together(const LegLine& a, const LegLine& b) const {
    if (context_.surface_known) return meet_at_surface(a, b);
    return meet_somewhere(a, b) && log10_by_chance(a, b) < kMaxLog10SecondLegs;
  }

  bool meet_at_surface(const LegLine& a, const LegLine& b) const {
    auto ca = crossing(a, d_), cb = crossing(b, d_);
    if (!ca || !cb) return false;
    const double apart = std::abs(ca->x - cb->x);
    if (ca->side * cb->side > 0) return apart <= d_;
    if (ca->side > cb->side) std::swap(ca, cb);  // the left one first
    return cb->x - ca->x >= -kBounceNoise * d_ && apart <= kLongestContact * d_;
  }

  /// Both legs go up from where their lines meet, and start near it.
  bool meet_somewhere(const LegLine& a, const LegLine& b) const {
    const double sine = a.along.cross(b.along);
    if (std::abs(sine) < kSameDirection) return false;
    const double s = (b.origin - a.origin).cross(b.along) / sine;
    const cv::Point2d apex = a.origin + s * a.along;
    for (const LegLine* leg : {&a, &b}) {
      const cv::Point2d far = far_end(points_, *leg, apex) - apex;
      if (far.y < kSameDirection * cv::norm(far)) return false;
      double nearest = std::numeric_limits<double>::infinity();
      for (const int i : leg->members) {
        const double place = (point_at(points_, i).at - apex).dot(far) / cv::norm(far);
        if (place < -kBounceNoise * d_) return false;
        nearest = std::min(nearest, place);
      }
      if (nearest > kLongestContact * d_) return false;
    }
    return true;
  }

  double union_weight(const LegLine& a, const LegLine& b) const {
    double weight = a.weight;
    for (const int i : b.members) {
      if (!std::binary_search(a.members.begin(), a.members.end(), i)) weight += point_at(points_, i).weight;
    }
    return weight;
  }

  /// How many legs like the second what the first leaves would make if it were no ball, log10.
  double log10_by_chance(const LegLine& one, const LegLine& two) const {
    std::vector<int> own, left;
    std::ranges::set_difference(two.members, one.members, std::back_inserter(own));
    std::ranges::set_difference(airborne_, one.members, std::back_inserter(left));
    leave_one_of_each_place(own);
    if (own.size() < kMinOwnImages) return std::numeric_limits<double>::infinity();
    if (own.size() == kMinOwnImages)  // any two make a line
      return std::log10(0.5 * static_cast<double>(left.size() * (left.size() - 1)) * kMeetByChance);
    std::vector<double> off;
    for (const int i : own) off.push_back(std::abs(two.off(point_at(points_, i).at)));
    return log10_nearest_by_chance(left.size(), std::move(off), kMinOwnImages, share_per_px_) +
           std::log10(kMeetByChance);
  }

  /// Two outlines of one thing lead to what is beyond it no more surely than one.
  void leave_one_of_each_place(std::vector<int>& images) const {
    std::vector<int> kept;
    for (const int i : images) {
      const bool known = std::ranges::any_of(kept, [&](int other) {
        return cv::norm(point_at(points_, i).at - point_at(points_, other).at) < kSameThingOfDiameter * d_;
      });
      if (!known) kept.push_back(i);
    }
    images = std::move(kept);
  }

  std::span<const PathPoint> points_;
  std::span<const int> airborne_;
  const PathContext& context_;
  double d_;
  double share_per_px_;  ///< of the view
};

}  // namespace

std::optional<Crossing> crossing(const LegLine& line, double diameter_px) {
  if (std::abs(line.along.y) < kSameDirection) return std::nullopt;
  const double s = (0.5 * diameter_px - line.origin.y) / line.along.y;
  const cv::Point2d up = line.along.y > 0 ? line.along : -line.along;
  return Crossing{line.origin.x + s * line.along.x, up.x > kSameDirection    ? 1.0
                                                    : up.x < -kSameDirection ? -1.0
                                                                             : 0.0};
}

cv::Point2d far_end(std::span<const PathPoint> points, const LegLine& leg, cv::Point2d from) {
  cv::Point2d far = point_at(points, leg.members.front()).at;
  for (const int i : leg.members) {
    if (cv::norm(point_at(points, i).at - from) > cv::norm(far - from)) far = point_at(points, i).at;
  }
  return far;
}

double leg_cost(const PathContext& context) { return context.surface_known ? kLegCost : kLegCostBlind; }

std::vector<LegLine> choose_legs(std::span<const PathPoint> points, std::span<const int> airborne,
                                 std::span<const LegLine> lines, const PathContext& context) {
  return LegPair(points, airborne, context).run(lines);
}

}  // namespace strobe::digitize
