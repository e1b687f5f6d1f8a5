#include "host/series/control_chart.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/statistics/distributions.hpp"

namespace strobe::host {
namespace {

using reduction::Estimate;

double normal_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

/// One side's, from zero. States are the sum's values in steps, the first one all sums at zero.
double one_sided_run_length(double limit, double shift) {
  constexpr int kStates = 100;
  const double step = 2.0 * limit / (2.0 * kStates - 1.0);
  const auto below = [&](double move) { return normal_below(move + kCusumAllowance - shift); };
  Eigen::MatrixXd stay = Eigen::MatrixXd::Identity(kStates, kStates);
  for (int from = 0; from < kStates; ++from) {
    stay(from, 0) -= below((0.5 - from) * step);
    for (int to = 1; to < kStates; ++to)
      stay(from, to) -= below((to - from + 0.5) * step) - below((to - from - 0.5) * step);
  }
  return stay.partialPivLu().solve(Eigen::VectorXd::Ones(kStates))(0);
}

/// As far from zero as a normal number that is as improbable as this Student's t.
double normal_score(double t, double degrees_of_freedom) {
  const double above = 0.5 * statistics::student_t_tail(std::abs(t), degrees_of_freedom);
  constexpr double kMin = 1e-300;
  return statistics::student_t_quantile(std::numeric_limits<double>::infinity(),
                                        std::clamp(above, kMin, 0.5));
}

/// One that lies further off changes what is learnt no more than this: it may be the first of a drift.
constexpr double kFarthestLearnt = 3.0;

}  // namespace

double average_run_length(double decision_interval, double shift) {
  return 1.0 / (1.0 / one_sided_run_length(decision_interval, shift) +
                1.0 / one_sided_run_length(decision_interval, -shift));
}

double decision_interval(double run_length) {
  double low = 0.1, high = 20.0;
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high);
    (average_run_length(middle) < run_length ? low : high) = middle;
  }
  return high;
}

double ControlChart::Learnt::score(const Estimate& measured) const {
  if (!(weight > 0.0)) return 0.0;
  const double off = (measured.value - mean) / std::sqrt(measured.sd * measured.sd + 1.0 / weight);
  if (!(degrees_of_freedom > 0.0)) return has_reference ? off : 0.0;
  const double factor = std::sqrt(sum_of_squares / degrees_of_freedom);
  const double learnt =
      factor > 0.0 ? normal_score(off / factor, degrees_of_freedom) : std::numeric_limits<double>::infinity();
  return std::copysign(std::min(std::abs(off), learnt), off);
}

void ControlChart::Learnt::learn(const Estimate& measured) {
  const double variance = measured.sd * measured.sd;
  if (!(weight > 0.0)) {
    mean = measured.value;
    weight = 1.0 / variance;
    return;
  }
  const double told = std::abs(score(measured));
  const double off = (measured.value - mean) * std::min(1.0, kFarthestLearnt / std::max(told, 1e-9));
  sum_of_squares += off * off / (variance + 1.0 / weight);
  degrees_of_freedom += 1.0;
  mean += off / (variance * weight + 1.0);
  weight += 1.0 / variance;
}

ControlChart::ControlChart(double decision_interval, std::optional<Estimate> reference)
    : limit_(decision_interval) {
  assert(!reference || reference->sd > 0.0);
  if (reference)
    begin_ = {
        .mean = reference->value, .weight = 1.0 / (reference->sd * reference->sd), .has_reference = true};
  learnt_ = begin_;
}

const ChartPoint& ControlChart::add(std::size_t shot, const Estimate& measured) {
  assert(measured.sd > 0.0);
  points_.push_back({.shot = shot, .measured = measured, .score = learnt_.score(measured)});
  judge(points_.size() - 1);
  if (!alarm_) learnt_.learn(measured);
  return points_.back();
}

void ControlChart::judge(std::size_t index) {
  const ChartPoint before = index > 0 ? points_[index - 1] : ChartPoint{};
  ChartPoint& now = points_[index];
  if (before.upper == 0.0) upper_since_ = index;
  if (before.lower == 0.0) lower_since_ = index;
  now.upper = std::max(0.0, before.upper + now.score - kCusumAllowance);
  now.lower = std::max(0.0, before.lower - now.score - kCusumAllowance);
  if (alarm_ || std::max(now.upper, now.lower) <= limit_) return;
  alarm_ = index;
  since_ = now.upper > limit_ ? upper_since_ : lower_since_;
}

std::optional<InControl> ControlChart::in_control(std::size_t end) const {
  Learnt learnt = begin_;
  for (std::size_t i = 0; i < std::min(end, points_.size()); ++i) learnt.learn(points_[i].measured);
  if (!(learnt.weight > 0.0)) return std::nullopt;
  const double factor = learnt.degrees_of_freedom > 0.0
                            ? std::max(1.0, std::sqrt(learnt.sum_of_squares / learnt.degrees_of_freedom))
                            : 1.0;
  return InControl{{learnt.mean, factor / std::sqrt(learnt.weight)}, factor};
}

}  // namespace strobe::host
