#include "host/clock/clock_estimate.hpp"

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
constexpr double kSpreadDoubt = 1.2;
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
constexpr double kLatenessDoubt = 0.35;  // sd of each of these, of its mean
constexpr double kStrange_per_s = 1e-5;  // density of messages that fit nothing, also of early ones

constexpr double kCredible = 0.01;  // share from which a slew is told
constexpr std::size_t kMaxStories = 40;
constexpr double kHopeless_per_s = 1e-9;
constexpr double kForgotten = 1e-6;  // share of a story that is dropped
constexpr double kBeaten = 1e-6;     // of a filter that is given up
constexpr double kAlike = 1.0;       // squared distance, in sds, of stories that are told as one

const Lateness& late_by(int i) { return kLateness[static_cast<std::size_t>(i)]; }

double gaussian(double x, double variance) {
  return std::exp(-0.5 * x * x / variance) / std::sqrt(2.0 * std::numbers::pi * variance);
}

constexpr int kNoBurst = -1;

bool as_wide(double one, double other) { return one < 9.0 * other && other < 9.0 * one; }

/// Offset and drift as one story has them.
struct Story {
  double weight = 0.0;
  double a = 0.0, b = 0.0;
  double paa = 0.0, pab = 0.0, pbb = 0.0;
  double squares = 0.0, count = 0.0;  ///< of innovations in spreads, as far as they tell of the spread
  bool slewed = false;                ///< a clock's rate was set lately, which nothing else confirms yet
  int burst = kNoBurst;               ///< how late messages are in the burst that goes on

  void pass(double s, double wander_per_s) {
    a += b * s;
    paa += 2.0 * s * pab + s * s * pbb + wander_per_s * s * s * s / 3.0;
    pab += s * pbb + wander_per_s * s * s / 2.0;
    pbb += wander_per_s * s;
  }

  void hear(double innovation, double variance) {
    const double gain_a = paa / variance, gain_b = pab / variance;
    a += gain_a * innovation;
    b += gain_b * innovation;
    pbb -= gain_b * pab;
    pab -= gain_a * pab;
    paa -= gain_a * paa;
  }

  /// Squared distance of the other, in this one's sds.
  double distance(const Story& other) const {
    const double da = other.a - a, db = other.b - b;
    return (da * da * pbb - 2.0 * da * db * pab + db * db * paa) / (paa * pbb - pab * pab);
  }

  void take(const Story& other) {
    const double sum = weight + other.weight;
    const double mine = weight / sum, its = other.weight / sum;
    const double da = other.a - a, db = other.b - b;
    a += its * da;
    b += its * db;
    paa = mine * paa + its * other.paa + mine * its * da * da;
    pab = mine * pab + its * other.pab + mine * its * da * db;
    pbb = mine * pbb + its * other.pbb + mine * its * db * db;
    squares = mine * squares + its * other.squares;
    count = mine * count + its * other.count;
    weight = sum;
  }
};

/// All stories under one spread of usual delays and one wander.
class StorySum {
 public:
  StorySum(double spread_s, double wander, double share)
      : spread_s_(spread_s), wander_per_s_(wander * wander), evidence_(std::log(share)) {
    for (const bool odd : {false, true}) {
      Story story;
      story.pbb = odd ? kOddDrift * kOddDrift : kUsualDrift * kUsualDrift;
      story.paa = 1.0;  // the first message tells the offset
      const double pairs = odd ? kOddPairs : 1.0 - kOddPairs;
      story.weight = pairs * (1.0 - kBurstShare);
      stories_.push_back(story);
      for (story.burst = 0; story.burst < kLatenesses; ++story.burst) {
        story.weight = pairs * kBurstShare * late_by(story.burst).share;
        stories_.push_back(story);
      }
    }
  }

  void hear(const ClockSample& point, double passed_s) {
    told_.clear();
    for (Story& story : stories_) {
      story.pass(passed_s, wander_per_s_);
      passed_s_ = passed_s;
      tell_on(story, point.offset_s - story.a);
    }
    std::swap(stories_, told_);
    normalize();
    merge();
  }

  double evidence() const { return evidence_; }
  double spread_s() const { return spread_s_; }
  double wander_per_s() const { return wander_per_s_; }
  const std::vector<Story>& stories() const { return stories_; }

  /// All as one, but for rates that may just have been set: that can never be excluded, and would be all of
  /// the sd.
  Story whole() const {
    Story all = stories_.front();
    for (std::size_t i = 1; i < stories_.size(); ++i) {
      if (!stories_[i].slewed || stories_[i].weight > kCredible) all.take(stories_[i]);
    }
    return all;
  }

 private:
  void tell_on(const Story& story, double innovation) {
    const double calm = story.burst == kNoBurst ? 1.0 - kBurstBegins : kBurstEnds;
    tell_usual(story, innovation, calm * (1.0 - kLone));
    tell_slewed(story, innovation, calm * kSlew);
    Story strange = story;
    strange.weight *= kStrange_per_s;
    add(strange);
    for (int late = 0; late < kLatenesses; ++late) {
      const double lone = calm * kLone * late_by(late).share;
      double burst = story.burst == late ? 1.0 - kBurstEnds : 0.0;
      if (story.burst == kNoBurst) burst = kBurstBegins * late_by(late).share;
      tell_late(story, innovation, late, lone, burst);
    }
  }

  void tell_usual(const Story& story, double innovation, double share) {
    const double variance = story.paa + spread_s_ * spread_s_;
    Story next = story;
    next.weight *= share * gaussian(innovation, variance);
    next.burst = kNoBurst;
    const double told = spread_s_ * spread_s_ / variance;
    next.squares += told * innovation * innovation / variance;
    next.count += told;
    next.hear(innovation, variance);
    add(next);
  }

  /// As a usual one, but the drift is another since the message before.
  void tell_slewed(Story story, double innovation, double share) {
    story.pass(-passed_s_, 0.0);
    story.pbb += kUsualDrift * kUsualDrift;
    story.pass(passed_s_, 0.0);
    story.slewed = true;
    tell_usual(story, innovation, share);
  }

  void tell_late(const Story& story, double innovation, int late, double lone, double burst) {
    const double mean_s = late_by(late).mean_s;
    const double doubt_s = kLatenessDoubt * mean_s;
    const double variance = story.paa + spread_s_ * spread_s_ + doubt_s * doubt_s;
    const double weight = story.weight * gaussian(innovation - mean_s, variance);
    Story next = story;
    next.hear(innovation - mean_s, variance);
    next.burst = kNoBurst;
    next.weight = weight * lone;
    add(next);
    next.burst = late;
    next.weight = weight * burst;
    add(next);
  }

  void add(const Story& story) {
    if (story.weight > kHopeless_per_s) told_.push_back(story);
  }

  void normalize() {
    double sum = 0.0;
    for (const Story& story : stories_) sum += story.weight;
    if (!(sum > 0.0)) return;
    evidence_ += std::log(sum);
    for (Story& story : stories_) story.weight /= sum;
  }

  void merge() {
    std::erase_if(stories_, [](const Story& story) { return story.weight < kForgotten; });
    std::sort(stories_.begin(), stories_.end(),
              [](const Story& x, const Story& y) { return x.weight > y.weight; });
    // What is likeliest is what has happened.
    if (!stories_.empty()) stories_.front().slewed = false;
    told_.clear();
    for (const Story& story : stories_) {
      const auto same = std::find_if(told_.begin(), told_.end(), [&](const Story& kept) {
        return kept.burst == story.burst && kept.slewed == story.slewed && as_wide(kept.pbb, story.pbb) &&
               as_wide(kept.paa, story.paa) && kept.distance(story) < kAlike;
      });
      if (same != told_.end()) {
        same->take(story);
      } else if (told_.size() < kMaxStories) {
        told_.push_back(story);
      }
    }
    std::swap(stories_, told_);
  }

  double spread_s_;
  double wander_per_s_;
  double evidence_;
  double passed_s_ = 0.0;  ///< since the message before
  std::vector<Story> stories_, told_;
};

using Filters = std::vector<StorySum>;

double best_evidence(const Filters& filters) {
  double best = -HUGE_VAL;
  for (const StorySum& filter : filters) best = std::max(best, filter.evidence());
  return best;
}

void hear_all(Filters& filters, std::span<const ClockSample> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double passed_s = i == 0 ? 0.0 : points[i].sent_s - points[i - 1].sent_s;
    for (StorySum& filter : filters) filter.hear(points[i], passed_s);
    const double least = best_evidence(filters) + std::log(kBeaten);
    std::erase_if(filters,
                  [&](const StorySum& f) { return f.stories().empty() || !(f.evidence() >= least); });
  }
}

Filters of_any_spread() {
  Filters filters;
  for (double spread_s = kNarrowest_s; spread_s < kWidest_s; spread_s *= std::exp(kSpreadStep)) {
    const double from_usual = std::log(spread_s / kSpread_s) / kSpreadDoubt;
    filters.emplace_back(spread_s, kEarlyWander, std::exp(-0.5 * from_usual * from_usual));
  }
  return filters;
}

const StorySum& likeliest(const Filters& filters) {
  return *std::max_element(filters.begin(), filters.end(),
                           [](const StorySum& x, const StorySum& y) { return x.evidence() < y.evidence(); });
}

Filters of_any_wander(double spread_s) {
  Filters filters;
  for (std::size_t i = 0; i < kWanders.size(); ++i)
    filters.emplace_back(spread_s, kWanders[i], kWanderShares[i]);
  return filters;
}

ClockEstimate summary(const Filters& filters, double at_s) {
  const double best = best_evidence(filters);
  Story all;
  double wander_per_s = 0.0, weights = 0.0;
  for (const StorySum& filter : filters) {
    Story one = filter.whole();
    one.weight = std::exp(filter.evidence() - best);
    wander_per_s += one.weight * filter.wander_per_s();
    weights += one.weight;
    if (all.weight == 0.0) {
      all = one;
    } else {
      all.take(one);
    }
  }
  return {at_s, all.a, all.b, all.paa, all.pbb, all.pab, wander_per_s / weights};
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
  hear_all(filters, points);
  if (filters.empty()) return std::nullopt;
  if (points.size() >= kEnoughForSpread) {
    const StorySum& best = likeliest(filters);
    const Story whole = best.whole();
    const double spread_s =
        best.spread_s() * std::sqrt(std::max(0.01, whole.squares / std::max(1.0, whole.count - 2.0)));
    filters = of_any_wander(spread_s);
    hear_all(filters, points);
    if (filters.empty()) return std::nullopt;
  }
  ClockEstimate now = summary(filters, points.back().sent_s);
  now.offset_s += origin_s;
  return now;
}

}  // namespace strobe::host
