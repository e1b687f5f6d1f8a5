#include "tests/studies/series/study.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

#include "common/flight/aerodynamics.hpp"
#include "common/reduction/running_statistics.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/reduction/reduce.hpp"
#include "common/statistics/distributions.hpp"
#include "host/series/compare.hpp"
#include "host/series/sample_size.hpp"
#include "host/series/sequential.hpp"
#include "host/session/shot.hpp"
#include "sim/motion/ball_path.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/studies/in_parallel.hpp"

namespace strobe::studies {
namespace {

using reduction::kQuantityCount;
using reduction::Quantities;
using reduction::Quantity;

/// What a laboratory does not know: the same for both series of a pair.
struct Errors {
  double scale = 0.0;            ///< of the calibration, relative
  double ball_diameter_m = 0.0;  ///< the true less the stated
  double drag_coefficient = flight::AirLaw{}.drag_coefficient, spin_decay_per_m = flight::AirLaw{}.spin_decay_per_m;
  bool calibrated = true;  ///< else the scale is the balls'
};

Errors drawn(const SeriesPlan& plan, std::uint64_t pair) {
  std::seed_seq words{static_cast<std::uint32_t>(plan.seed), static_cast<std::uint32_t>(pair)};
  std::mt19937_64 random(words);
  std::normal_distribution<double> normal;
  Errors e;
  e.scale = plan.scale_sd * normal(random);
  e.ball_diameter_m = plan.ball_diameter_sd_m * normal(random);
  e.drag_coefficient += flight::AirLaw{}.drag_coefficient_sd * normal(random);
  e.spin_decay_per_m = std::max(0.0, e.spin_decay_per_m + flight::AirLaw{}.spin_decay_sd_per_m * normal(random));
  e.calibrated = pair % 2 == 0;
  return e;
}

sim::Scene with(sim::Scene scene, const Errors& e) {
  scene.ball.diameter_m += e.ball_diameter_m;
  scene.air.drag_coefficient = e.drag_coefficient;
  scene.air.spin_decay_per_m = e.spin_decay_per_m;
  return scene;
}

sim::Shooter shooter_of(const sim::Scene& scene, std::uint64_t seed) {
  auto shooter = sim::Shooter::make(scene, seed);
  assert(shooter);
  return std::move(*shooter);
}

/// The mean that endless shots of the scene would have: what one without spread does, and by how much the mean of many of
/// the condition is off that, since numbers are not linear in what spreads.
class Truth {
 public:
  explicit Truth(const sim::Scene& scene) {
    constexpr int kShots = 2000;
    const Quantities middle = without_spread(scene);
    sim::Shooter shooter = shooter_of(scene, 0x7275);
    std::array<reduction::RunningStatistics, kQuantityCount> all;
    for (int shot = 1; shot <= kShots; ++shot) {
      const Quantities truth = shooter.shoot(shot).truth;
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (truth[q] && middle[q]) off_[i] += (*truth[q] - *middle[q]) / kShots;
        if (truth[q]) all[i].add(*truth[q]);
      }
    }
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      if (all[i].count() > 1) sd_[i] = all[i].sample_sd();
  }

  Quantities of(const sim::Scene& scene) const {
    Quantities mean = without_spread(scene);
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      if (auto& value = mean[static_cast<Quantity>(i)]) *value += off_[i];
    return mean;
  }

  /// Of shots.
  double scatter_sd(Quantity q) const { return sd_[static_cast<std::size_t>(q)]; }

 private:
  static Quantities without_spread(const sim::Scene& scene) {
    return shooter_of(sim::without_spread(scene), 1).shoot(1).truth;
  }

  std::array<double, kQuantityCount> off_{}, sd_{};
};

/// As a laboratory measures it: with the stated ball, and the calibration's scale.
host::Shot measured(reduction::Frame frame, const sim::Scene& stated, const SeriesPlan& plan,
                          const Errors& e) {
  frame.ball_diameter_m = stated.ball.diameter_m;
  frame.ball_diameter_sd_m = plan.ball_diameter_sd_m;
  frame.px_per_m.reset();
  frame.px_per_m_sd.reset();
  if (e.calibrated) {
    frame.px_per_m = stated.camera.px_per_m * (1.0 + e.scale);
    frame.px_per_m_sd = stated.camera.px_per_m * plan.scale_sd;
  }
  host::Shot shot;
  const auto readout = reduction::reduce(frame, reduction::Estimator::best);
  if (!readout) {
    shot.rejected = readout.error().message;
    return shot;
  }
  shot.readout = *readout;
  shot.rejected = host::rejection_reason(*readout);
  auto budget =
      reduction::uncertainty_budget(frame, reduction::Estimator::best, {}, reduction::SourceChoice::shared);
  if (budget) shot.budget = std::move(*budget);
  return shot;
}

struct Measured {
  host::Series series;
  Quantities truth;
};

Measured measure(const SeriesPlan& plan, const sim::Scene& stated, const Truth& truth, const Errors& e,
                 std::uint64_t seed) {
  const sim::Scene scene = with(stated, e);
  sim::Shooter shooter = shooter_of(scene, seed);
  Measured m{{}, truth.of(scene)};
  for (int shot = 1; m.series.counted() < plan.shots && shot <= 3 * plan.shots; ++shot)
    m.series.add(measured(shooter.shoot(shot).frame, stated, plan, e));
  return m;
}

double square(double x) { return x * x; }

void add_means(const Measured& m, SeriesCoverage& coverage) {
  const host::SeriesSummary summary = m.series.summary("");
  coverage.rejected += summary.rejected;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const host::QuantitySummary& s = summary.quantities[i];
    const auto& truth = m.truth[static_cast<Quantity>(i)];
    if (!truth || !s.expanded_uncertainty) continue;
    coverage.means[i].add(s.mean - *truth, *s.expanded_uncertainty, square(s.shared_sd / *s.total_sd));
    const double t = statistics::student_t_half_width(reduction::kExpandedLevel, s.n - 1.0);
    coverage.by_scatter[i].add(s.mean - *truth, t * *s.standard_error, 0.0);
  }
}

void add_differences(const Measured& a, const Measured& b, SeriesCoverage& coverage) {
  const host::Comparison comparison = host::compare(a.series, b.series);
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& d = comparison.of(q);
    if (!d || !a.truth[q] || !b.truth[q]) continue;
    coverage.differences[i].add(d->difference - (*a.truth[q] - *b.truth[q]), d->expanded_uncertainty,
                                square(d->shared_sd / d->total_sd));
  }
}

}  // namespace

void Held::add(double error, double half_width, double shared_share) {
  ++intervals;
  if (std::abs(error) <= half_width) ++held;
  shared += shared_share;
}

void Held::add(const Held& other) {
  intervals += other.intervals;
  held += other.held;
  shared += other.shared;
}

SeriesCoverage run(const SeriesPlan& plan, std::atomic<int>& done) {
  std::vector<std::optional<Truth>> truths(plan.scenes.size());
  in_parallel(truths.size(), static_cast<unsigned>(plan.threads),
              [&](std::size_t i) { truths[i].emplace(plan.scenes[i]); });
  const auto pairs = static_cast<std::size_t>(plan.series / 2);
  std::vector<SeriesCoverage> of_pair(pairs);
  in_parallel(pairs, static_cast<unsigned>(plan.threads), [&](std::size_t pair) {
    const Errors errors = drawn(plan, pair);
    std::array<Measured, 2> both;
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t condition = (pair / 2 + k) % plan.scenes.size();
      both[k] = measure(plan, plan.scenes[condition], *truths[condition], errors,
                        plan.seed * 1'000'003 + 2 * pair + k + 1);
      add_means(both[k], of_pair[pair]);
    }
    add_differences(both[0], both[1], of_pair[pair]);
    ++done;
  });
  SeriesCoverage all;
  for (const SeriesCoverage& one : of_pair) {
    all.rejected += one.rejected;
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      all.means[i].add(one.means[i]);
      all.differences[i].add(one.differences[i]);
      all.by_scatter[i].add(one.by_scatter[i]);
    }
  }
  return all;
}

namespace {

/// So short that `shots` of that scatter would do if it were known, beside what they share.
double wanted_half_width(double scatter_sd, double shared_sd, double shots) {
  return 1.959964 * std::hypot(scatter_sd / std::sqrt(shots), shared_sd);
}

/// Until it is known. What is shared is what the first shot says, as it is the same for all but for their spread.
void add_sequential(const SeriesPlan& plan, std::size_t which, const Truth& truth, SequentialSeries& result) {
  const Errors errors = drawn(plan, which);
  const sim::Scene& stated = plan.scenes[which % plan.scenes.size()];
  const Quantity q = kSequentialQuantities[which % kSequentialQuantities.size()];
  const sim::Scene scene = with(stated, errors);
  sim::Shooter shooter = shooter_of(scene, plan.seed * 1'000'003 + which + 1);
  host::Series series;
  std::optional<host::Wanted> wanted;
  for (int shot = 1; shot <= kMaxSequentialShots; ++shot) {
    host::Shot one = measured(shooter.shoot(shot).frame, stated, plan, errors);
    one.until_known = "asked";
    series.add(one);
    if (series.values(q).empty()) continue;
    const host::SeriesSummary summary = series.summary("");
    const host::QuantitySummary& s = summary.quantities[static_cast<std::size_t>(q)];
    const double shots_if_known = kShotsIfKnown[which / kSequentialQuantities.size() % kShotsIfKnown.size()];
    if (!wanted)
      wanted = {q, wanted_half_width(truth.scatter_sd(q), s.shared_sd, shots_if_known), false};
    const auto state = host::known_so_far(summary, *wanted).state;
    if (state == host::Known::State::never) break;  // later shots share more than the first
    if (state != host::Known::State::known) continue;
    const double error = s.mean - *truth.of(scene)[q];
    const double shared = square(s.shared_sd / *s.total_sd);
    result.sequential.add(error, *s.expanded_uncertainty, shared);
    result.plain.add(error, host::mean_half_width(*s.scatter_sd, s.shared_sd, s.n), shared);
    result.shots += s.n;
    return;
  }
  ++result.not_known;
}

}  // namespace

std::array<SequentialSeries, kShotsIfKnown.size()> run_sequential(const SeriesPlan& plan, std::atomic<int>& done) {
  std::vector<std::optional<Truth>> truths(plan.scenes.size());
  in_parallel(truths.size(), static_cast<unsigned>(plan.threads),
              [&](std::size_t i) { truths[i].emplace(plan.scenes[i]); });
  const auto count = static_cast<std::size_t>(plan.series);
  std::vector<SequentialSeries> of_series(count);
  in_parallel(count, static_cast<unsigned>(plan.threads), [&](std::size_t i) {
    add_sequential(plan, i, *truths[i % plan.scenes.size()], of_series[i]);
    ++done;
  });
  std::array<SequentialSeries, kShotsIfKnown.size()> all;
  for (std::size_t i = 0; i < count; ++i) {
    SequentialSeries& sum = all[i / kSequentialQuantities.size() % kShotsIfKnown.size()];
    sum.not_known += of_series[i].not_known;
    sum.shots += of_series[i].shots;
    sum.sequential.add(of_series[i].sequential);
    sum.plain.add(of_series[i].plain);
  }
  return all;
}

}  // namespace strobe::studies
