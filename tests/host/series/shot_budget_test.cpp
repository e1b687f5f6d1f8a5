// Budgets of photographs whose flashes were matched.
#include <cmath>
#include <random>

#include "common/reduction/mixture.hpp"
#include "host/assembly/assemble.hpp"
#include "host/series/budget_lines.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host_test;
using reduction::Quantity;

namespace {

host::AssemblySettings settings() {
  host::AssemblySettings s;
  s.machine_lag_s = kMachineLag_s;
  s.analysis.flash_time_sd_s = 0.1e-6;
  s.budgets = true;
  return s;
}

/// Of a fine photograph, on which microseconds between the flashes tell, so that several assignments are plausible.
SyntheticShot fine_shot() {
  Scenario sc;
  sc.seed = 3;
  sc.noise_mm = 0.01;
  sc.equator_noise_rad = 0.002;
  std::mt19937 generator(3);
  std::normal_distribution<double> late_us(0.0, 1.0);
  for (int k = 0; k < sc.flash_count; ++k) sc.late_us[k] = std::abs(late_us(generator));
  return make_shot(sc);
}

}  // namespace

TEST_GROUP(ShotBudget){};

TEST(ShotBudget, OfAMixtureSumsUpToItsSdWithALineForTheAssignment) {
  const auto made = fine_shot();
  const auto result = host::shot_readout(made.shot, made.frame, settings());
  CHECK_TRUE(result.readout.assignments->hypotheses > 1);
  CHECK_TRUE(result.assembled.has_value());
  const reduction::Budget budget = reduction::mixture_budget(result.assembled->frame, result.readout);
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
  auto made = fine_shot();
  auto quiet = settings();
  quiet.budgets = false;
  CHECK_FALSE(host::shot_readout(made.shot, made.frame, quiet).assembled.has_value());
  made.frame.images.clear();
  made.frame.image_count = 0;
  const host::AssembledShot shot = host::assemble(made.shot, made.frame, settings());
  CHECK_TRUE(reduction::mixture_budget(shot.frame, {}).sources.empty());
}

TEST(ShotBudget, HasLinesWhoseSharesSumUpToOne) {
  const auto made = fine_shot();
  const auto result = host::shot_readout(made.shot, made.frame, settings());
  const reduction::Budget budget = reduction::mixture_budget(result.assembled->frame, result.readout);
  double shares = 0.0;
  for (const host::BudgetLine& line : host::budget_lines(budget, Quantity::vx_td_mps)) shares += line.share;
  DOUBLES_EQUAL(1.0, shares, 1e-12);
}
