#include "host/clock/clock_estimate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace strobe::host {
namespace {

// Before the first message. Two crystals of +-50 ppm each; one pair in two hundred has a bad or a slewed one.
constexpr double kUsualDrift = 40e-6;
constexpr double kOddDrift = 800e-6;
constexpr double kOddPairs = 0.005;
// A clock's rate is set, as by a time service: at one message in so many.
constexpr double kSlew = 1e-5;
// A lone late message, a burst that begins, a burst that ends with a message.
constexpr double kLone = 0.1;
constexpr double kBurstBegins = 0.02;
constexpr double kBurstEnds = 0.1;
constexpr double kBurstShare = kBurstBegins / (kBurstBegins + kBurstEnds);
// The spread of usual delays: 30 us, within a factor of 3.3 in two cases of three.
constexpr double kSpread_s = 30e-6;
constexpr double kSpreadLogSd = 1.2;
constexpr double kNarrowest_s = 1e-6;
constexpr double kWidest_s = 3e-3;
constexpr double kSpreadStep = 0.5;
// The crystals' wander, in drift per square root of a second: from one in an oven to one in a draught.
constexpr std::array<double, 5> kWanders{0.003e-6, 0.009e-6, 0.025e-6, 0.06e-6, 0.2e-6};
constexpr std::array<double, 5> kWanderShares{0.15, 0.1, 0.15, 0.5, 0.1};
constexpr double kEarlyWander = 0.03e-6;
// From so many points on the spread is found first, and the wander with it.
constexpr std::size_t kEnoughForSpread = 20;

/// By how much late messages are late: some milliseconds, between a quarter and forty times as much at most.
struct Lateness {
  double mean_s, share;
};
constexpr std::array<Lateness, 9> kLateness{{{0.2e-3, 0.06},
                                             {0.5e-3, 0.10},
                                             {1e-3, 0.15},
                                             {2e-3, 0.20},
                                             {4e-3, 0.20},
                                             {8e-3, 0.15},
                                             {16e-3, 0.08},
                                             {40e-3, 0.04},
                                             {150e-3, 0.02}}};
constexpr int kLatenesses = static_cast<int>(kLateness.size());
constexpr double kLatenessSd = 0.35;     // sd of each of these, of its mean
constexpr double kOutlier_per_s = 1e-5;  // density of messages that fit nothing, also of early ones

constexpr double kCredibleSlew = 0.01;  // share from which a slew is reported
constexpr std::size_t kMaxHypotheses = 40;
constexpr double kMinWeight_per_s = 1e-9;
constexpr double kMinWeight = 1e-6;      // share of a hypothesis that is dropped
constexpr double kMinLikelihood = 1e-6;  // of a filter that is given up, over the best
constexpr double kMergeDistance = 1.0;   // squared distance, in sds, of hypotheses that are merged

const Lateness& late_by(int i) { return kLateness[static_cast<std::size_t>(i)]; }

double gaussian(double x, double variance) {
  return std::exp(-0.5 * x * x / variance) / std::sqrt(2.0 * std::numbers::pi * variance);
}

constexpr int kNoBurst = -1;

bool as_wide(double one, double other) { return one < 9.0 * other && other < 9.0 * one; }

/// A Kalman filter of offset and drift, under one choice of which messages were late.
struct Hypothesis {
  double weight = 0.0;
  Eigen::Vector2d mean{0.0, 0.0};
  Eigen::Matrix2d covariance{{1.0, 0.0}, {0.0, 0.0}};  // the first message shows the offset
  double squares = 0.0, count = 0.0;  ///< of innovations in spreads, as far as they show the spread
  bool slewed = false;                ///< a clock's rate was set lately, which nothing else confirms yet
  int burst = kNoBurst;               ///< how late messages are in the burst that goes on

  double offset_s() const { return mean[0]; }
  double offset_var() const { return covariance(0, 0); }

  void predict(double s, double wander_per_s) {
    const Eigen::Matrix2d step{{1.0, s}, {0.0, 1.0}};
    const Eigen::Matrix2d wander{{s * s * s / 3.0, s * s / 2.0}, {s * s / 2.0, s}};
    mean = step * mean;
    covariance = step * covariance * step.transpose() + wander_per_s * wander;
  }

  void update(double innovation, double variance) {
    const Eigen::Vector2d gain = covariance.col(0) / variance;
    mean += gain * innovation;
    covariance -= (gain * covariance.row(0)).eval();
  }

  /// Squared distance of the other, in this one's sds.
  double distance(const Hypothesis& other) const {
    const Eigen::Vector2d apart = other.mean - mean;
    return apart.dot(covariance.inverse() * apart);
  }

  /// Keeps the mean and the covariance of the sum of both.
  void merge(const Hypothesis& other) {
    const double sum = weight + other.weight;
    const double mine = weight / sum, its = other.weight / sum;
    const Eigen::Vector2d apart = other.mean - mean;
    mean += its * apart;
    covariance = mine * covariance + its * other.covariance + mine * its * apart * apart.transpose();
    squares = mine * squares + its * other.squares;
    count = mine * count + its * other.count;
    weight = sum;
  }
};

/// A sum of Gaussians: all hypotheses under one spread of usual delays and one wander.
class GaussianSum {
 public:
  GaussianSum(double spread_s, double wander, double share)
      : spread_s_(spread_s), wander_per_s_(wander * wander), evidence_(std::log(share)) {
    for (const bool odd : {false, true}) {
      Hypothesis h;
      h.covariance(1, 1) = odd ? kOddDrift * kOddDrift : kUsualDrift * kUsualDrift;
      const double pairs = odd ? kOddPairs : 1.0 - kOddPairs;
      h.weight = pairs * (1.0 - kBurstShare);
      hypotheses_.push_back(h);
      for (h.burst = 0; h.burst < kLatenesses; ++h.burst) {
        h.weight = pairs * kBurstShare * late_by(h.burst).share;
        hypotheses_.push_back(h);
      }
    }
  }

  void update(const ClockSample& point, double passed_s) {
    next_.clear();
    for (Hypothesis& h : hypotheses_) {
      h.predict(passed_s, wander_per_s_);
      passed_s_ = passed_s;
      extend(h, point.offset_s - h.offset_s());
    }
    std::swap(hypotheses_, next_);
    normalize();
    merge();
  }

  double evidence() const { return evidence_; }
  double spread_s() const { return spread_s_; }
  double wander_per_s() const { return wander_per_s_; }
  const std::vector<Hypothesis>& hypotheses() const { return hypotheses_; }

  /// All as one, but for rates that may just have been set: that can never be excluded, and would be all of
  /// the sd.
  Hypothesis whole() const {
    Hypothesis all = hypotheses_.front();
    for (std::size_t i = 1; i < hypotheses_.size(); ++i) {
      if (!hypotheses_[i].slewed || hypotheses_[i].weight > kCredibleSlew) all.merge(hypotheses_[i]);
    }
    return all;
  }

 private:
  void extend(const Hypothesis& h, double innovation) {
    const double calm = h.burst == kNoBurst ? 1.0 - kBurstBegins : kBurstEnds;
    extend_usual(h, innovation, calm * (1.0 - kLone));
    extend_slewed(h, innovation, calm * kSlew);
    Hypothesis outlier = h;
    outlier.weight *= kOutlier_per_s;
    add(outlier);
    for (int late = 0; late < kLatenesses; ++late) {
      const double lone = calm * kLone * late_by(late).share;
      double burst = h.burst == late ? 1.0 - kBurstEnds : 0.0;
      if (h.burst == kNoBurst) burst = kBurstBegins * late_by(late).share;
      extend_late(h, innovation, late, lone, burst);
    }
  }

  void extend_usual(const Hypothesis& h, double innovation, double share) {
    const double variance = h.offset_var() + spread_s_ * spread_s_;
    Hypothesis next = h;
    next.weight *= share * gaussian(innovation, variance);
    next.burst = kNoBurst;
    const double share_of_spread = spread_s_ * spread_s_ / variance;
    next.squares += share_of_spread * innovation * innovation / variance;
    next.count += share_of_spread;
    next.update(innovation, variance);
    add(next);
  }

  /// As a usual one, but the drift is another since the message before.
  void extend_slewed(Hypothesis h, double innovation, double share) {
    h.predict(-passed_s_, 0.0);
    h.covariance(1, 1) += kUsualDrift * kUsualDrift;
    h.predict(passed_s_, 0.0);
    h.slewed = true;
    extend_usual(h, innovation, share);
  }

  void extend_late(const Hypothesis& h, double innovation, int late, double lone, double burst) {
    const double mean_s = late_by(late).mean_s;
    const double sd_s = kLatenessSd * mean_s;
    const double variance = h.offset_var() + spread_s_ * spread_s_ + sd_s * sd_s;
    const double weight = h.weight * gaussian(innovation - mean_s, variance);
    Hypothesis next = h;
    next.update(innovation - mean_s, variance);
    next.burst = kNoBurst;
    next.weight = weight * lone;
    add(next);
    next.burst = late;
    next.weight = weight * burst;
    add(next);
  }

  void add(const Hypothesis& h) {
    if (h.weight > kMinWeight_per_s) next_.push_back(h);
  }

  void normalize() {
    double sum = 0.0;
    for (const Hypothesis& h : hypotheses_) sum += h.weight;
    if (!(sum > 0.0)) return;
    evidence_ += std::log(sum);
    for (Hypothesis& h : hypotheses_) h.weight /= sum;
  }

  void merge() {
    std::erase_if(hypotheses_, [](const Hypothesis& h) { return h.weight < kMinWeight; });
    std::sort(hypotheses_.begin(), hypotheses_.end(),
              [](const Hypothesis& x, const Hypothesis& y) { return x.weight > y.weight; });
    // What is likeliest is what has happened.
    if (!hypotheses_.empty()) hypotheses_.front().slewed = false;
    next_.clear();
    for (const Hypothesis& h : hypotheses_) {
      const auto same = std::find_if(next_.begin(), next_.end(), [&](const Hypothesis& kept) {
        return kept.burst == h.burst && kept.slewed == h.slewed &&
               as_wide(kept.covariance(1, 1), h.covariance(1, 1)) &&
               as_wide(kept.offset_var(), h.offset_var()) && kept.distance(h) < kMergeDistance;
      });
      if (same != next_.end()) {
        same->merge(h);
      } else if (next_.size() < kMaxHypotheses) {
        next_.push_back(h);
      }
    }
    std::swap(hypotheses_, next_);
  }

  double spread_s_;
  double wander_per_s_;
  double evidence_;
  double passed_s_ = 0.0;  ///< since the message before
  std::vector<Hypothesis> hypotheses_, next_;
};

using Filters = std::vector<GaussianSum>;

double best_evidence(const Filters& filters) {
  double best = -HUGE_VAL;
  for (const GaussianSum& filter : filters) best = std::max(best, filter.evidence());
  return best;
}

void update_all(Filters& filters, std::span<const ClockSample> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double passed_s = i == 0 ? 0.0 : points[i].sent_s - points[i - 1].sent_s;
    for (GaussianSum& filter : filters) filter.update(points[i], passed_s);
    const double least = best_evidence(filters) + std::log(kMinLikelihood);
    std::erase_if(filters,
                  [&](const GaussianSum& f) { return f.hypotheses().empty() || !(f.evidence() >= least); });
  }
}

Filters of_any_spread() {
  Filters filters;
  for (double spread_s = kNarrowest_s; spread_s < kWidest_s; spread_s *= std::exp(kSpreadStep)) {
    const double from_usual = std::log(spread_s / kSpread_s) / kSpreadLogSd;
    filters.emplace_back(spread_s, kEarlyWander, std::exp(-0.5 * from_usual * from_usual));
  }
  return filters;
}

const GaussianSum& likeliest(const Filters& filters) {
  return *std::max_element(filters.begin(), filters.end(), [](const GaussianSum& x, const GaussianSum& y) {
    return x.evidence() < y.evidence();
  });
}

Filters of_any_wander(double spread_s) {
  Filters filters;
  for (std::size_t i = 0; i < kWanders.size(); ++i)
    filters.emplace_back(spread_s, kWanders[i], kWanderShares[i]);
  return filters;
}

ClockEstimate summary(const Filters& filters, double at_s) {
  const double best = best_evidence(filters);
  Hypothesis all;
  double wander_per_s = 0.0, weights = 0.0;
  for (const GaussianSum& filter : filters) {
    Hypothesis one = filter.whole();
    one.weight = std::exp(filter.evidence() - best);
    wander_per_s += one.weight * filter.wander_per_s();
    weights += one.weight;
    if (all.weight == 0.0) {
      all = one;
    } else {
      all.merge(one);
    }
  }
  return {at_s,
          all.mean[0],
          all.mean[1],
          all.covariance(0, 0),
          all.covariance(1, 1),
          all.covariance(0, 1),
          wander_per_s / weights};
}

}  // namespace

ClockEstimate ClockEstimate::at(double sent_s) const {
  const double s = sent_s - at_s;
  const double wandered = wander_per_s * std::abs(s);
  ClockEstimate then = *this;
  then.at_s = sent_s;
  then.offset_s += drift * s;
  then.offset_var_s2 += 2.0 * s * covariance_s + s * s * drift_var + wandered * s * s / 3.0;
  then.covariance_s += s * drift_var + wandered * s / 2.0;
  then.drift_var += wandered;
  return then;
}

std::optional<ClockEstimate> estimate_clock(std::span<const ClockSample> given) {
  if (given.size() < kMinSamplesForEstimate || !(given.front().sent_s < given.back().sent_s))
    return std::nullopt;
  // The first message's offset is near zero, as its prior has it: a second wide.
  std::vector<ClockSample> points(given.begin(), given.end());
  const double origin_s = points.front().offset_s;
  for (ClockSample& point : points) point.offset_s -= origin_s;
  Filters filters = of_any_spread();
  update_all(filters, points);
  if (filters.empty()) return std::nullopt;
  if (points.size() >= kEnoughForSpread) {
    const GaussianSum& best = likeliest(filters);
    const Hypothesis whole = best.whole();
    const double spread_s =
        best.spread_s() * std::sqrt(std::max(0.01, whole.squares / std::max(1.0, whole.count - 2.0)));
    filters = of_any_wander(spread_s);
    update_all(filters, points);
    if (filters.empty()) return std::nullopt;
  }
  ClockEstimate now = summary(filters, points.back().sent_s);
  now.offset_s += origin_s;
  return now;
}

}  // namespace strobe::host
