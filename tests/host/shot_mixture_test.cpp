// Readouts of shots of which several assignments of flashes to images are plausible, and their budgets.
#include <fmt/format.h>

#include <cmath>
#include <random>

#include "common/reduction/mixture.hpp"
#include "host/assembly/assemble.hpp"
#include "host/series/series.hpp"
#include "host/session/shot.hpp"
#include "tests/host/synthetic_shot.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::host_test;
using reduction::Flag;
using reduction::Quantity;
using reduction::Readout;

constexpr double kFlashTimeSd_s = 0.1e-6;

host::AssemblySettings settings() {
  host::AssemblySettings s;
  s.machine_lag_s = kMachineLag_s;
  s.analysis.flash_time_sd_s = kFlashTimeSd_s;
  s.ball.fastest_spin_radps = 600.0;
  return s;
}

/// As a fine photograph shows it: 0.01 mm of noise, on which 20 m/s make half a microsecond. Flashes come up to a few
/// microseconds late, each by another time.
Scenario fine(std::uint32_t seed, double lateness_us) {
  Scenario sc;
  sc.seed = seed;
  sc.noise_mm = 0.01;
  sc.equator_noise_rad = 0.002;
  std::mt19937 generator(seed);
  std::normal_distribution<double> late_us(0.0, lateness_us);
  for (int k = 0; k < sc.flash_count; ++k) sc.late_us[k] = std::abs(late_us(generator));
  return sc;
}

Readout readout(const SyntheticShot& made) {
  return host::shot_readout(made.shot, made.frame, settings()).readout;
}

const std::map<Quantity, double>& truth() {
  static const Bounce b;
  static const std::map<Quantity, double> numbers{{Quantity::vx_td_mps, b.vx_td},
                                                  {Quantity::vy_td_mps, b.vy_td},
                                                  {Quantity::vx_lo_mps, b.vx_lo},
                                                  {Quantity::vy_lo_mps, b.vy_lo},
                                                  {Quantity::dwell_time_ms, b.dwell_s * 1e3}};
  return numbers;
}

}  // namespace

TEST_GROUP(ShotMixture){};

TEST(ShotMixture, MicrosecondsBetweenFlashesCostNoShotAndTheSdsStayTrue) {
  constexpr int kShots = 150;
  double squares = 0.0;
  int rejected = 0, outliers = 0, mixed = 0;
  for (std::uint32_t seed = 1; seed <= kShots; ++seed) {
    const Readout r = readout(make_shot(fine(seed, 1.0)));
    rejected += host::rejection_reason(r).has_value() ? 1 : 0;
    outliers += r.flags.has(Flag::outlier_image) ? 1 : 0;
    mixed += r.assignments->hypotheses > 1 ? 1 : 0;
    for (const auto& [q, value] : truth())
      squares += std::pow((*r.value[q] - value) / *r.sd[q], 2) / static_cast<double>(truth().size());
  }
  CHECK_TEXT(mixed > kShots / 2, fmt::format("{} of {} are mixtures", mixed, kShots).c_str());
  LONGS_EQUAL(0, rejected);
  // Of one clean photograph in a thousand an image is left out by chance: two of 150 are a hundredth as likely as none.
  CHECK_TEXT(outliers <= 1, fmt::format("{} of {} shots lost a good image", outliers, kShots).c_str());
  // Mean squares of 150 normal errors over their variances scatter by sqrt(2/150), 0.115; the five numbers of a shot
  // go together in part, so that their mean scatters by no more. Three of that.
  DOUBLES_EQUAL(1.0, squares / kShots, 0.35);
}

TEST(ShotMixture, NumbersOfAlikeHypothesesAreLinearInTheTimesOfTheImages) {
  // The same hypotheses, once enough of them that derivatives are used and once few, each reduced by itself.
  const SyntheticShot made = make_shot(fine(3, 1.0));
  const host::AssembledShot shot = host::assemble(made.shot, made.frame, settings());
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> off_s(-0.4e-6, 0.4e-6);
  std::vector<reduction::AssignedTimes> many;
  for (int h = 0; h < 60; ++h) {
    reduction::AssignedTimes& one = many.emplace_back(reduction::AssignedTimes{{}, 1.0});
    for (const auto& image : shot.frame.images)
      one.time_s.push_back(image.time_s + (h == 0 ? 0.0 : off_s(generator)));
  }
  const auto linear = reduction::reduce_hypotheses(shot.frame, many);
  const double first = *linear->value[Quantity::e];
  double mean = first, squares = 0.0;
  for (const reduction::AssignedTimes& one : many) {
    const std::vector pair{many.front(), reduction::AssignedTimes{one.time_s, 1e9}};  // in effect the second alone
    const double e = *reduction::reduce_hypotheses(shot.frame, pair)->value[Quantity::e];
    mean += (e - first) / 60.0;
    squares += (e - first) * (e - first) / 60.0;
  }
  // Second order: 0.4 us of 3 ms, squared, is 2e-8 of a number near 1.
  DOUBLES_EQUAL(mean, *linear->value[Quantity::e], 1e-7);
  const double sd = std::sqrt(squares - (mean - first) * (mean - first));
  DOUBLES_EQUAL(1.0, *linear->assignments->sd[Quantity::e] / sd, 0.02);
}

TEST(ShotMixture, IsRejectedOnlyWhereNumbersDifferByMoreThanTheTolerance) {
  Readout r;
  r.value[Quantity::v_td_mps] = 20.0;
  r.value[Quantity::vx_td_mps] = 15.0;
  r.assignments.emplace().sd[Quantity::vx_td_mps] =
      0.09;  // two hypotheses 0.18 m/s apart, 0.9 % of the speed
  r.flags.set(Flag::flash_match_ambiguous);
  CHECK_FALSE(host::rejection_reason(r).has_value());
  CHECK_TRUE(host::rejection_reason(r, {.percent = 0.8}).has_value());
  r.assignments->sd[Quantity::vx_td_mps] = 0.11;
  STRCMP_EQUAL(
      "which flash made which image is not certain, and the numbers depend on it (vx_td_mps by 1.1 %)",
      host::rejection_reason(r)->c_str());
}

TEST(ShotMixture, ALateFlashCountsAtItsOwnTime) {
  Scenario sc = fine(2, 0.5);
  sc.late_us[last_flash_before_touchdown(sc) - 1] = 160.0;
  const Readout r = readout(make_shot(sc));
  CHECK_TRUE(r.flags.has(Flag::late_flash));
  CHECK_FALSE(host::rejection_reason(r).has_value());
  LONGS_EQUAL(1, r.assignments->hypotheses);
  for (const auto& [q, value] : truth()) CHECK_TRUE(std::abs(*r.value[q] - value) < 5.0 * *r.sd[q]);
}

TEST(ShotMixture, AnImageInContactThatFewWouldMissIsNoSecondHypothesis) {
  // The dwell time would be three milliseconds longer, with odds of 1 to 200: no sd of a tenth of it.
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    const Readout r = readout(make_shot(fine(seed, 0.0)));
    CHECK_TRUE(*r.assignments->sd[Quantity::dwell_time_ms] < 0.01);
  }
}

TEST_GROUP(ShotBudget) {
  SyntheticShot made = make_shot(fine(3, 1.0));
  host::AssemblySettings with_budgets = settings();
  void setup() override { with_budgets.budgets = true; }
};

TEST(ShotBudget, OfAMixtureSumsUpToItsSdWithALineForTheAssignment) {
  const auto result = host::shot_readout(made.shot, made.frame, with_budgets);
  CHECK_TRUE(result.readout.assignments->hypotheses > 1);
  CHECK_TRUE(result.matched.has_value());
  const reduction::Budget budget = reduction::mixture_budget(*result.matched, result.readout);
  for (const Quantity q : {Quantity::vx_td_mps, Quantity::vy_lo_mps, Quantity::e, Quantity::mu}) {
    double assignment = 0.0, combined = 0.0;
    for (const auto& source : budget.sources) {
      if (source.source == reduction::Source::assignment) assignment = source.of(q);
      combined = std::hypot(combined, source.of(q));
    }
    DOUBLES_EQUAL(*result.readout.assignments->sd[q], assignment, 1e-15);
    const double all = std::hypot(*result.readout.sd[q], result.readout.sd_systematic[q].value_or(0.0));
    DOUBLES_EQUAL(1.0, combined / all, 1e-6);  // both parts are scaled to the mixture's
  }
}

TEST(ShotBudget, IsEmptyWithoutAFrameAndAbsentUnlessAskedFor) {
  CHECK_FALSE(host::shot_readout(made.shot, made.frame, settings()).matched.has_value());
  made.frame.images.clear();
  made.frame.image_count = 0;
  const host::AssembledShot shot = host::assemble(made.shot, made.frame, with_budgets);
  CHECK_TRUE(reduction::mixture_budget(shot.frame, {}).sources.empty());
}

TEST(ShotBudget, HasLinesWhoseSharesSumUpToOne) {
  const auto result = host::shot_readout(made.shot, made.frame, with_budgets);
  const reduction::Budget budget = reduction::mixture_budget(*result.matched, result.readout);
  double shares = 0.0;
  for (const host::BudgetLine& line : host::budget_lines(budget, Quantity::vx_td_mps)) shares += line.share;
  DOUBLES_EQUAL(1.0, shares, 1e-12);
}
