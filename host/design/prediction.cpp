#include "host/design/prediction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/flight/parabola.hpp"
#include "common/reduction/matching/flash_match.hpp"
#include "common/reduction/mixture.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/series/sample_size.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {
namespace {

using reduction::kQuantityCount;
using reduction::Quantity;

// A spin so many sd off is another one: noise alone makes none of it.
constexpr double kFarOff = 10.0;

bool is_of_spin(Quantity q) {
  return q == Quantity::omega_td_radps || q == Quantity::omega_lo_radps || q == Quantity::slip_lo_mps;
}

/// Mean and mean square of one number.
struct Moments {
  int n = 0;
  double sum = 0.0, squares = 0.0;

  void add(double value) {
    ++n;
    sum += value;
    squares += value * value;
  }
  double mean() const { return sum / n; }
  double mean_square() const { return squares / n; }
  double sd() const { return std::sqrt(std::max(0.0, mean_square() - mean() * mean())); }
};

/// One source over the balls whose budgets were made.
struct SourceEffect {
  reduction::BudgetSource source;
  std::array<Moments, kQuantityCount> effects;
};

class Collector {
 public:
  /// The number as it is without noise, its sd as it is stated with noise: what noise leaves open of a spin,
  /// say, is in that.
  void add(const reduction::Readout& exact, const reduction::Readout& noisy) {
    for (std::size_t q = 0; q < kQuantityCount; ++q) {
      const auto& value = exact.value[static_cast<Quantity>(q)];
      const auto sd = reduction::total_sd(noisy, static_cast<Quantity>(q));
      if (!value || !sd) continue;
      values_[q].add(*value);
      sds_[q].add(*sd);
    }
  }

  void add(const reduction::Budget& budget) {
    ++budgets_;
    for (const reduction::BudgetSource& s : budget.sources) {
      SourceEffect& seen = sources_[{s.source, s.number}];
      seen.source = s;
      for (std::size_t q = 0; q < kQuantityCount; ++q) seen.effects[q].add(s.effect[q]);
    }
  }

  std::optional<PredictedQuantity> of(std::size_t q) const {
    if (values_[q].n == 0) return std::nullopt;
    PredictedQuantity p;
    p.mean = values_[q].mean();
    p.spread = values_[q].sd();
    p.shot_sd = std::sqrt(sds_[q].mean_square());
    double shared = 0.0, all = 0.0;
    for (const auto& [key, seen] : sources_) all += seen.effects[q].squares / budgets_;
    for (const auto& [key, seen] : sources_) {
      // Of the balls without the source it does nothing.
      const double square = seen.effects[q].squares / budgets_;
      if (!(square > 0.0)) continue;
      const bool is_shared = reduction::is_shared(seen.source.source);
      const double mean = seen.effects[q].sum / budgets_;
      if (is_shared) shared += mean * mean;
      BudgetLine& line = p.budget.emplace_back();
      line.source = reduction::name_of(seen.source);
      line.type = seen.source.type;
      line.input_sd = seen.source.input_sd;
      line.input_unit = seen.source.input_unit;
      line.effect = std::sqrt(square);
      line.share = square / all;
      line.shared = is_shared;
    }
    // Of the few balls that have budgets, for all.
    if (all > 0.0) p.shared_sd = p.shot_sd * std::sqrt(shared / all);
    std::ranges::sort(p.budget, std::greater{}, &BudgetLine::effect);
    return p;
  }

 private:
  std::array<Moments, kQuantityCount> values_, sds_;
  std::map<std::pair<reduction::Source, int>, SourceEffect> sources_;
  int budgets_ = 0;
};

/// Which flashes may have made the images, as the host will find it out from the photograph; empty: none.
std::vector<reduction::AssignedTimes> assignments(const ExpectedShot& shot, const ExpectedTrain& train,
                                                  const ExpectedBall& ball, const SetUp& set_up) {
  auto track = matching::image_track(shot.frame);
  if (!track) return {};
  track->air = flight::aerodynamics(ball.ball, ball.air_density_kgpm3, {}, ball.air_law());
  if (ball.kind) track->dwell = matching::DwellLimits::about(ball.kind->contact.dwell_s);
  track->time_sd_s = set_up.flash_time_sd_s;
  const matching::ArrivalPrior prior{train.touchdown_s, std::numbers::sqrt2 * train.arrival_sd_s};
  const auto match = matching::match_flashes(train.flash_s, *track, prior);
  if (!match) return {};
  std::vector<reduction::AssignedTimes> assigned;
  for (const matching::FlashAssignment& hypothesis : match->hypotheses) {
    reduction::AssignedTimes& times = assigned.emplace_back(reduction::AssignedTimes{{}, hypothesis.weight});
    const double first_s = train.flash_s[static_cast<std::size_t>(hypothesis.flash.front())];
    for (const int flash : hypothesis.flash)
      times.time_s.push_back(train.flash_s[static_cast<std::size_t>(flash)] - first_s);
  }
  return assigned;
}

/// As the host reduces a photograph whose flashes it has to name.
Result<reduction::Readout> readout_of(reduction::Frame frame, const ExpectedShot& shot,
                                      const ExpectedTrain& train, const ExpectedBall& ball,
                                      const SetUp& set_up, bool match) {
  if (match && !frame.images.empty()) {
    const auto assigned = assignments(shot, train, ball, set_up);
    if (!assigned.empty()) {
      for (std::size_t i = 0; i < frame.images.size(); ++i)
        frame.images[i].time_s = assigned.front().time_s[i];
      return reduction::reduce_hypotheses(frame, assigned);
    }
  }
  return reduction::reduce(frame, reduction::Estimator::best);
}

/// Whether its spins are other than the ball's, or may be.
bool is_aliased(const reduction::Readout& readout, const BallCourse& course) {
  if (readout.flags.has(reduction::Flag::spin_aliased)) return true;
  const auto off = [&](Quantity q, double truth_radps) {
    const auto sd = reduction::total_sd(readout, q);
    return readout.value[q] && sd && std::abs(*readout.value[q] - truth_radps) > kFarOff * *sd;
  };
  return off(Quantity::omega_td_radps, course.touchdown().omega_radps) ||
         off(Quantity::omega_lo_radps, course.lift_off().omega_radps);
}

void note_images(const ExpectedShot& shot, bool first, Prediction& prediction) {
  const auto widen = [first](std::array<int, 2>& range, int n) {
    range = first ? std::array{n, n} : std::array{std::min(range[0], n), std::max(range[1], n)};
  };
  widen(prediction.incoming, shot.incoming);
  widen(prediction.rebound, shot.rebound);
  prediction.largest_overlap = std::max(prediction.largest_overlap, shot.largest_overlap);
  prediction.most_at_one_place = std::max(prediction.most_at_one_place, shot.most_at_one_place);
}

}  // namespace

double PredictedQuantity::scatter_sd() const {
  return std::sqrt(spread * spread + shot_sd * shot_sd - shared_sd * shared_sd);
}

double PredictedQuantity::mean_sd(int n) const { return std::hypot(scatter_sd() / std::sqrt(n), shared_sd); }

double PredictedQuantity::expanded(int n) const { return expected_half_width(scatter_sd(), shared_sd, n); }

Result<Prediction> predict(const ExpectedBall& ball, const SetUp& set_up, const ExpectedTrain& train,
                           const PredictionOptions& options) {
  if (auto problem = problem_of(ball)) return fail(*problem);
  const Eigen::Vector2d gravity_mps2 = flight::gravity_mps2(set_up.surface_angle_rad);
  const MatchTolerance tolerance{set_up.match_tolerance_percent, ball.ball.diameter_m};
  Prediction prediction;
  Collector collector;
  for (const BallDraw& draw : ball_draws(options.balls)) {
    const auto course = BallCourse::make(ball, draw, gravity_mps2);
    if (!course) return tl::unexpected(course.error());
    const ExpectedShot shot = expected_shot(*course, draw, train, ball, set_up);
    note_images(shot, prediction.balls++ == 0, prediction);
    if (!shot.not_known.empty()) {
      ++prediction.reasons[shot.not_known];
      continue;
    }
    const auto seed = static_cast<std::uint64_t>(prediction.balls);
    const auto noisy = readout_of(with_noise(shot.frame, seed), shot, train, ball, set_up, options.match);
    const auto why = noisy ? rejection_reason(*noisy, tolerance) : std::optional(noisy.error().message);
    if (why) {
      ++prediction.reasons[why->substr(0, why->find(" ("))];  // without the one ball's own numbers
      continue;
    }
    if (is_aliased(*noisy, *course)) ++prediction.aliased;
    if (const auto exact = reduction::reduce(shot.frame, reduction::Estimator::best))
      collector.add(*exact, *noisy);
    if (prediction.readable++ < static_cast<int>(options.budgets)) {
      if (const auto budget = reduction::uncertainty_budget(shot.frame)) collector.add(*budget);
    }
  }
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    if (!prediction.spins_known() && is_of_spin(static_cast<Quantity>(q))) continue;
    prediction.quantities[q] = collector.of(q);
  }
  return prediction;
}

}  // namespace strobe::host
