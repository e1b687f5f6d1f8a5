#include "host/design/train_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/flight/parabola.hpp"
#include "host/assembly/coded_spacing.hpp"

namespace strobe::host {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// While a train is searched for, few balls stand for many.
constexpr PredictionOptions kCoarse{.balls = 16, .budgets = 0, .match = true};
constexpr PredictionOptions kFine{.balls = 64, .budgets = 0, .match = true};
// A ball that cannot be read weighs as much as sds twenty times as large.
constexpr double kUnreadable = 3.0;
constexpr double kPeriodStep = 1.06;
constexpr double kLongestOverPlan = 2.5;
// Trains that differ by less are taken for alike, and the simpler one is kept.
constexpr double kWorthWhile = 1.02;
constexpr int kPasses = 6;
constexpr double kRounding_s = 1e-9;
// The arrival's deviates that a train of its own length allows for.
constexpr double kArrivalSds = 3.0;

/// Mean of ln(sd) of what is wanted, and what a train is fined for.
double score(const Prediction& p, const TrainWish& wish) {
  if (p.readable == 0) return kNever;
  double sum = kUnreadable * (1.0 - p.readable_share());
  for (const reduction::Quantity q : wish.quantities) {
    const auto& quantity = p.of(q);
    if (!quantity || !(quantity->shot_sd > 0.0)) return kNever;
    sum += std::log(quantity->shot_sd) / static_cast<double>(wish.quantities.size());
  }
  const int most = std::max(p.incoming[1], p.rebound[1]);
  if (wish.most_images > 0 && most > wish.most_images) sum += most - wish.most_images;
  return sum;
}

/// Scale and ball as if they were exact: what no train can better would hide what it can.
SetUp with_exact_scale(SetUp s) {
  s.camera.px_per_m = s.px_per_m;
  s.camera.px_per_m_sd = 0.0;
  s.camera.map_errors.clear();
  s.ball_diameter_sd_m = 0.0;
  return s;
}

struct Candidate {
  PlanFile plan;
  ExpectedTrain train;
  std::string problem;
  double score = kNever;
};

/// From the first to the last instant at which a ball may be seen, on the time axis of its touchdown.
struct Window {
  double from_s = 0.0, to_s = 0.0;
};

class Search {
 public:
  Search(const ExpectedBall& ball, const SetUp& set_up, const RigFile& rig, const PlanFile& plan,
         const TrainWish& wish, const std::function<bool(double)>& progress)
      : ball_(ball),
        set_up_(with_exact_scale(set_up)),
        rig_(rig),
        plan_(plan),
        wish_(wish),
        progress_(progress),
        window_(window()) {}

  Result<FoundTrain> run() {
    Candidate given = coded(plan_);
    if (auto failed = rate(given); !failed) return tl::unexpected(failed.error());
    Candidate spaced = given;
    sweep_periods(spaced);
    // Of a train with fewer images than the given one, another of as few is the measure.
    const Candidate& measure = wish_.most_images > 0 ? spaced : given;
    Candidate best = spaced;
    exchange(best);
    return checked(measure, spaced, best);
  }

 private:
  bool digitized() const { return set_up_.measured_by == MeasuredBy::digitizer; }
  double shortest_interval_s() const { return to_seconds(set_up_.shortest_interval()); }

  /// As `strobe fire` would code it.
  Candidate coded(const PlanFile& plan) const {
    Candidate c;
    SpacedPlan spaced = spaced_plan(plan, rig_, digitized());
    c.problem = std::move(spaced.problem);
    c.plan = std::move(spaced.plan);
    c.train = expected_train(c.plan.shot(), set_up_, ball_);
    return c;
  }

  Result<void> rate(Candidate& c) {
    ++tried_;
    const auto prediction = predict(ball_, set_up_, c.train, kCoarse);
    if (!prediction) return tl::unexpected(prediction.error());
    c.score = score(*prediction, wish_);
    return {};
  }

  bool go_on(double share) const { return !progress_ || progress_(share); }

  void sweep_periods(Candidate& best) {
    const double longest_s = kLongestOverPlan * to_seconds(plan_.even.period);
    for (double period_s = shortest_interval_s(); period_s < longest_s; period_s *= kPeriodStep) {
      PlanFile plan = plan_;
      plan.intervals.clear();
      plan.spacing =
          plan_.spacing == Spacing::even && plan_.intervals.empty() ? Spacing::even : Spacing::coded;
      plan.even.period = microseconds{std::llround(1e6 * period_s)};
      plan.period_stated = true;
      keep_length(plan);
      if (plan_problem(plan.shot(), set_up_.limits)) continue;
      Candidate c = coded(plan);
      if (c.problem.empty() && rate(c) && c.score < best.score) best = c;
      if (!go_on(0.3 * std::log(period_s / shortest_interval_s()) /
                 std::log(longest_s / shortest_interval_s())))
        return;
    }
  }

  /// A burst lasts as long as the plan's, however often it flashes; a free train as long as a ball may be
  /// seen.
  void keep_length(PlanFile& plan) const {
    if (plan.even.train == Train::gated) {
      const double share = to_seconds(plan_.even.period) / to_seconds(plan.even.period);
      plan.even.flash_count = std::max(2, static_cast<int>(std::lround(share * plan_.even.flash_count)));
      return;
    }
    const ExpectedTrain train = expected_train(plan_.shot(), set_up_, ball_);
    const Window& seen = window_;
    const double wait_s = kArrivalSds * train.arrival_sd_s + to_seconds(plan.even.period);
    const double impact_s = std::min(train.touchdown_s, wait_s - seen.from_s);
    plan.even.impact_at = microseconds{std::llround(1e6 * impact_s)};
    const Duration exposure = plan.even.impact_at + microseconds{std::llround(1e6 * (wait_s + seen.to_s))};
    plan.even.exposure = std::min(plan_.even.exposure, std::max<Duration>(exposure, milliseconds{1}));
  }

  Window window() const {
    constexpr double kStep_s = 0.25e-3, kLongest_s = 0.5;
    Window seen;
    const Eigen::Vector2d gravity_mps2 = flight::gravity_mps2(set_up_.surface_angle_rad);
    for (const BallDraw& draw : ball_draws(kCoarse.balls)) {
      const auto course = BallCourse::make(ball_, draw, gravity_mps2);
      if (!course) continue;
      const auto seen_at = [&](double time_s) {
        const ExpectedTrain one{{time_s}, 0.0, 0.0};
        const ExpectedShot shot = expected_shot(*course, draw, one, ball_, set_up_);
        return !shot.frame.images.empty() || course->at(time_s).in_contact || !shot.not_known.empty();
      };
      double t = 0.0;
      while (t > -kLongest_s && (t == 0.0 || seen_at(t))) t -= kStep_s;
      seen.from_s = std::min(seen.from_s, t);
      t = course->dwell_s();
      while (t < kLongest_s && (t == course->dwell_s() || seen_at(t))) t += kStep_s;
      seen.to_s = std::max(seen.to_s, t);
    }
    return seen;
  }

  /// One flash at a time is moved, left out or added, until nothing helps.
  void exchange(Candidate& best) {
    Candidate c = best;
    cut_to_window(c);
    if (!rate(c)) return;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double before = c.score;
      for (std::size_t i = 0; i <= c.train.flash_s.size(); ++i) {
        try_at(i, c);
        if (!go_on(0.3 +
                   0.7 * (pass + static_cast<double>(i) / static_cast<double>(c.train.flash_s.size() + 1)) /
                       kPasses))
          return;
      }
      if (c.score > before - 1e-3) break;
    }
    c.plan = plan_of(c.train);
    if (plan_problem(c.plan.shot(), set_up_.limits)) return;
    if (rate(c) && c.score < best.score - std::log(kWorthWhile)) best = c;
  }

  void cut_to_window(Candidate& c) const {
    const Window& seen = window_;
    const double wait_s = kArrivalSds * c.train.arrival_sd_s;
    std::erase_if(c.train.flash_s, [&](double t) {
      const double since_s = t - c.train.touchdown_s;
      return since_s < seen.from_s - wait_s || since_s > seen.to_s + wait_s;
    });
  }

  void try_at(std::size_t i, Candidate& c) {
    std::vector<std::vector<double>> trains;
    const std::vector<double>& now = c.train.flash_s;
    const double step_s = 0.125 * shortest_interval_s();
    if (i < now.size()) {
      for (const double steps : {-8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0}) {
        std::vector<double> moved = now;
        moved[i] += steps * step_s;
        trains.push_back(std::move(moved));
      }
      std::vector<double> fewer = now;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
      trains.push_back(std::move(fewer));
    }
    std::vector<double> more = now;
    const double at_s =
        i == 0 ? now.front() - shortest_interval_s()
               : (i < now.size() ? 0.5 * (now[i - 1] + now[i]) : now.back() + shortest_interval_s());
    more.insert(more.begin() + static_cast<std::ptrdiff_t>(i), at_s);
    trains.push_back(std::move(more));
    for (std::vector<double>& train : trains) {
      if (!playable(train)) continue;
      Candidate tried = c;
      tried.train.flash_s = std::move(train);
      if (rate(tried) && tried.score < c.score) c = std::move(tried);
    }
  }

  bool playable(const std::vector<double>& train) const {
    if (train.size() < 2 || train.size() > static_cast<std::size_t>(set_up_.limits.max_flashes)) return false;
    for (std::size_t i = 1; i < train.size(); ++i)
      if (train[i] - train[i - 1] < shortest_interval_s() - kRounding_s) return false;
    return true;
  }

  /// The plan that fires these flashes, to the microsecond.
  PlanFile plan_of(ExpectedTrain& train) const {
    PlanFile plan = plan_;
    plan.spacing = Spacing::even;
    plan.intervals.clear();
    for (std::size_t i = 1; i < train.flash_s.size(); ++i)
      plan.intervals.push_back(microseconds{std::llround(1e6 * (train.flash_s[i] - train.flash_s[i - 1]))});
    plan.even.period = *std::ranges::min_element(plan.intervals);
    const double first_s = train.flash_s.front();
    if (plan.even.train == Train::gated) {
      plan.even.flash_count = static_cast<int>(train.flash_s.size());
      plan.even.gate_delay += microseconds{std::llround(1e6 * first_s)};
    } else {
      plan.even.impact_at = microseconds{std::llround(1e6 * (train.touchdown_s - first_s))};
      plan.even.exposure =
          std::accumulate(plan.intervals.begin(), plan.intervals.end(), plan.even.period / 2);
      plan.even.exposure = std::max(plan.even.exposure, plan.even.impact_at + milliseconds{1});
    }
    train = expected_train(plan.shot(), set_up_, ball_);
    return plan;
  }

  /// With more balls: the best, else the best of evenly spaced or coded ones, else the one that they are
  /// measured by.
  Result<FoundTrain> checked(const Candidate& measure, const Candidate& spaced, const Candidate& best) {
    const auto before = predict(ball_, set_up_, measure.train, kFine);
    if (!before) return tl::unexpected(before.error());
    for (const Candidate* candidate : {&best, &spaced}) {
      const auto after = predict(ball_, set_up_, candidate->train, kFine);
      if (!after) return tl::unexpected(after.error());
      if (score(*after, wish_) < score(*before, wish_) - std::log(kWorthWhile))
        return FoundTrain{candidate->plan, {}, {}, gain(*before, *after, wish_.quantities), tried_};
    }
    return FoundTrain{measure.plan, {}, "no train within the limits is better by 2 % or more", 1.0, tried_};
  }

  const ExpectedBall& ball_;
  SetUp set_up_;
  const RigFile& rig_;
  const PlanFile& plan_;
  const TrainWish& wish_;
  const std::function<bool(double)>& progress_;
  const Window window_;
  int tried_ = 0;
};

}  // namespace

Result<FoundTrain> best_train(const ExpectedBall& ball, const SetUp& set_up, const RigFile& rig,
                              const PlanFile& plan, const TrainWish& wish,
                              const std::function<bool(double)>& progress) {
  auto found = Search(ball, set_up, rig, plan, wish, progress).run();
  if (!found) return found;
  auto prediction = predict(ball, set_up, expected_train(found->plan.shot(), set_up, ball));
  if (!prediction) return tl::unexpected(prediction.error());
  found->prediction = std::move(*prediction);
  return found;
}

double gain(const Prediction& one, const Prediction& other,
            const std::vector<reduction::Quantity>& quantities) {
  double sum = 0.0;
  int n = 0;
  for (const reduction::Quantity q : quantities) {
    const auto &a = one.of(q), &b = other.of(q);
    if (!a || !b || !(a->shot_sd > 0.0 && b->shot_sd > 0.0)) continue;
    sum += std::log(a->shot_sd / b->shot_sd);
    ++n;
  }
  return n > 0 ? std::exp(sum / n) : 1.0;
}

}  // namespace strobe::host
