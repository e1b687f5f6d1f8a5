#include "host/digitize/path/flight_legs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/leg_line.hpp"

namespace strobe::digitize {
namespace {

double log_choose(std::size_t n, std::size_t k) {
  double sum = 0.0;
  for (std::size_t i = 1; i <= k; ++i)
    sum += std::log(static_cast<double>(n - k + i) / static_cast<double>(i));
  return sum;
}

/// ln of the probability of `least` or more successes of `trials`.
double log_tail(std::size_t trials, std::size_t least, double probability) {
  const double odds = probability / (1.0 - probability);
  const double first = log_choose(trials, least) + static_cast<double>(least) * std::log(probability) +
                       static_cast<double>(trials - least) * std::log1p(-probability);
  double sum = 1.0, term = 1.0;  // over the first
  for (std::size_t k = least; k < trials; ++k) {
    term *= odds * static_cast<double>(trials - k) / static_cast<double>(k + 1);
    sum += term;
  }
  return std::min(0.0, first + std::log(sum));
}

}  // namespace

double log10_curves_by_chance(std::size_t points, std::size_t members, std::size_t parameters, double share) {
  assert(members <= points);
  if (members <= parameters) return std::numeric_limits<double>::infinity();
  const double probability = std::clamp(share, 1e-12, 0.5);
  // Every choice of the points that fix the curve, and every number of members, is a trial of its own.
  const double trials = std::log(static_cast<double>(points - parameters)) + log_choose(points, parameters);
  return (trials + log_tail(points - parameters, members - parameters, probability)) / std::log(10.0);
}

double log10_nearest_by_chance(std::size_t points, std::vector<double> off_px, std::size_t parameters,
                               double share_per_px) {
  std::ranges::sort(off_px);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t nearest = parameters + 1; nearest <= off_px.size(); ++nearest) {
    const double share = 2.0 * std::max(kMinResidual_px, off_px[nearest - 1]) * share_per_px;
    least = std::min(least, log10_curves_by_chance(points, nearest, parameters, share));
  }
  return least;
}

double share_of_view_per_px(std::span<const PathPoint> points, std::span<const int> eligible,
                            double diameter_px) {
  if (eligible.empty()) return 1.0;
  cv::Point2d least = point_at(points, eligible.front()).at, most = least;
  for (const int i : eligible) {
    const cv::Point2d at = point_at(points, i).at;
    least = {std::min(least.x, at.x), std::min(least.y, at.y)};
    most = {std::max(most.x, at.x), std::max(most.y, at.y)};
  }
  const double width = most.x - least.x + 2.0 * diameter_px, height = most.y - least.y + 2.0 * diameter_px;
  return (width + height) / (width * height);
}

namespace {

// Across one diameter of travel the scale changes by up to about a tenth where the ball flies steeply towards
// the camera; a camera held askew by some degrees makes a term of the same size.
constexpr double kPerspectiveSd = 0.1;
// The weight of a prior that leaves a term out.
constexpr double kLeftOut = 1e18;
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
  if (value_[2] > kFarthest_sd * std::sqrt(covariance_(2, 2))) return false;
  return std::ranges::all_of(members, [&](int i) {
    const cv::Point2d p = point_at(points, i).at;
    const double u = (p.x - origin_.x) / unit_px_, v = (p.y - origin_.y) / unit_px_;
    return 1.0 - value_[3] * u - 2.0 * value_[4] * v > 0.0;  // else it turns back over itself
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

namespace {

using Shape = FlightCurve::Shape;

// A seed is three images among so many neighbours of the first and the second, and the next image is within
// as many of the longest step: some are hidden, some are none, trains have unequal intervals.
constexpr std::size_t kNeighbours = 4;

class LegSearch {
 public:
  LegSearch(std::span<const PathPoint> points, std::span<const int> eligible, const PathContext& context)
      : points_(points), context_(context), d_(context.diameter_px), free_(eligible.begin(), eligible.end()) {
    std::ranges::sort(free_, {}, [this](int i) { return at(i).x; });
    share_per_px_ = share_of_view_per_px(points_, free_, d_);
  }

  std::vector<FlightLeg> run() {
    while (auto leg = next()) {
      std::erase_if(free_, [&](int i) { return has(leg->members, i); });
      const auto after =
          std::ranges::find_if(legs_, [&](const FlightLeg& l) { return first_x(l) > first_x(*leg); });
      legs_.insert(after, std::move(*leg));
    }
    return std::move(legs_);
  }

 private:
  struct Candidate {
    FlightLeg leg;
    double log10_chance;
  };

  cv::Point2d at(int i) const { return point_at(points_, i).at; }
  static bool has(const std::vector<int>& members, int i) {
    return std::ranges::find(members, i) != members.end();
  }
  double first_x(const FlightLeg& leg) const { return at(leg.members.front()).x; }
  double last_x(const FlightLeg& leg) const { return at(leg.members.back()).x; }

  std::optional<FlightLeg> next() const {
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      for (std::size_t j = i + 1; j < std::min(free_.size(), i + 1 + kNeighbours); ++j) {
        for (std::size_t k = j + 1; k < std::min(free_.size(), j + 1 + kNeighbours); ++k)
          grow({free_[i], free_[j], free_[k]}, candidates);
      }
    }
    std::ranges::stable_sort(candidates, {}, &Candidate::log10_chance);
    for (Candidate& c : candidates)
      if (fits_in(c.leg)) return std::move(c.leg);
    return std::nullopt;
  }

  double allowed_off(int i, const FlightCurve& curve) const {
    return leg_tolerance(point_at(points_, i), d_) + kFarthest_sd * curve.sd(at(i));
  }

  double longest_step(const std::vector<int>& members) const {
    double longest = 0.0;
    for (std::size_t k = 1; k < members.size(); ++k)
      longest = std::max(longest, cv::norm(at(members[k]) - at(members[k - 1])));
    return longest;
  }

  /// A curve known no better than a radius predicts no image.
  bool is_vague(const FlightCurve& curve, int i) const { return kFarthest_sd * curve.sd(at(i)) > 0.5 * d_; }

  /// The nearest image that the curve leads to.
  std::optional<int> nearest_on(const FlightCurve& curve, const std::vector<int>& members) const {
    double least = kNeighbours * longest_step(members);
    std::optional<int> nearest;
    for (const int i : free_) {
      if (has(members, i) || is_vague(curve, i)) continue;
      if (std::abs(curve.off(at(i))) > allowed_off(i, curve)) continue;
      double apart = std::numeric_limits<double>::infinity(), aside = apart;
      for (const int m : members) {
        apart = std::min(apart, cv::norm(at(m) - at(i)));
        aside = std::min(aside, std::abs(at(m).x - at(i).x));
      }
      if (apart > least || aside < kSamePlaceOfDiameter * d_) continue;
      least = apart;
      nearest = i;
    }
    return nearest;
  }

  void grow(std::vector<int> members, std::vector<Candidate>& candidates) const {
    for (std::size_t k = 1; k < members.size(); ++k)
      if (at(members[k]).x - at(members[k - 1]).x < kSamePlaceOfDiameter * d_) return;
    const bool known = std::ranges::any_of(candidates, [&](const Candidate& c) {
      return std::ranges::all_of(members, [&](int i) { return has(c.leg.members, i); });
    });
    if (known) return;
    auto curve = FlightCurve::fit(points_, members, d_);
    while (curve) {
      const auto more = nearest_on(*curve, members);
      if (!more) break;
      members.push_back(*more);
      std::ranges::sort(members, {}, [this](int i) { return at(i).x; });
      curve = FlightCurve::fit(points_, members, d_);
    }
    if (!curve) return;
    const double log10_chance = by_chance(members);
    if (-log10_chance * std::numbers::ln10 < kThousandToOne) return;
    FlightLeg leg{*curve, std::move(members), 0.0};
    for (const int i : leg.members) leg.weight += point_at(points_, i).weight;
    candidates.push_back({std::move(leg), log10_chance});
  }

  /// With the shape that is the least likely by chance.
  double by_chance(const std::vector<int>& members) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Shape shape : {Shape::line, Shape::parabola, Shape::conic}) {
      const auto curve = FlightCurve::fit(points_, members, d_, shape);
      if (!curve) continue;
      std::vector<double> off;
      for (const int i : members) off.push_back(std::abs(curve->off(at(i))));
      least = std::min(least, log10_nearest_by_chance(free_.size(), std::move(off),
                                                      static_cast<std::size_t>(shape), share_per_px_));
    }
    return least + std::log10(3.0);  // three shapes are tried
  }

  bool fits_in(const FlightLeg& leg) const {
    for (std::size_t k = 0; k <= legs_.size(); ++k) {
      const FlightLeg* before = k > 0 ? &legs_[k - 1] : nullptr;
      const FlightLeg* after = k < legs_.size() ? &legs_[k] : nullptr;
      if ((before == nullptr || joined(*before, leg)) && (after == nullptr || joined(leg, *after)))
        return true;
    }
    return false;
  }

  /// The left leg falls towards the right one, which rises, and they cross between their images.
  bool joined(const FlightLeg& left, const FlightLeg& right) const {
    if (last_x(left) > first_x(right) + kBounceNoise * d_) return false;
    double from = last_x(left) - kBounceNoise * d_, to = first_x(right) + kBounceNoise * d_;
    const auto above = [&](double x) -> std::optional<double> {
      const auto l = left.curve.height(x), r = right.curve.height(x);
      return l && r ? std::optional(*l - *r) : std::nullopt;
    };
    const auto start = above(from), end = above(to);
    if (!start || !end || *start < 0.0 || *end > 0.0) return false;
    for (int round = 0; round < 40; ++round) {
      const double middle = 0.5 * (from + to);
      const auto there = above(middle);
      if (!there) return false;
      (*there > 0.0 ? from : to) = middle;
    }
    const auto falls = left.curve.slope(from), rises = right.curve.slope(from);
    if (!falls || !rises || *falls >= 0.0 || *rises <= 0.0) return false;
    return !context_.surface_known || *left.curve.height(from) <= (0.5 + kBounceNoise) * d_;
  }

  std::span<const PathPoint> points_;
  const PathContext& context_;
  double d_;
  std::vector<int> free_;  ///< by x
  std::vector<FlightLeg> legs_;
  double share_per_px_ = 1.0;
};

}  // namespace

std::vector<FlightLeg> flight_legs(std::span<const PathPoint> points, std::span<const int> eligible,
                                   const PathContext& context) {
  return LegSearch(points, eligible, context).run();
}

}  // namespace strobe::digitize
