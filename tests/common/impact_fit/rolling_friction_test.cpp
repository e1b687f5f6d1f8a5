#include "common/impact/fit/rolling_friction.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/common/impact_fit/check.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::conditions;
using strobe::testing::true_rebounds;

namespace {

constexpr double kRadius = ball::kThesisDiameter_m / 2.0;

std::vector<RollingFriction> of(const std::vector<Observation>& observations, double alpha = 0.55) {
  std::vector<RollingFriction> out;
  for (const Observation& o : observations) out.push_back(*rolling_friction(o, {.alpha = alpha}));
  return out;
}

}  // namespace

TEST_GROUP(RollingFriction){};

// Whether the ball slides or grips, whatever mu and e_x.
TEST(RollingFriction, FindsTheOffsetThatMadeTheReboundWithoutKnowingTheFriction) {
  for (const double mu : {0.0, 0.3, 0.6, 2.0}) {
    const auto made = true_rebounds(conditions(), {mu, 0.15, 0.003, 2.5, 0.6});
    for (const RollingFriction& r : of(made, 0.6)) {
      const auto& o =
          *std::find_if(made.begin(), made.end(), [&](const auto& x) { return x.name == r.name; });
      const double rolling = 0.5 * (o.touchdown.vx_mps - kRadius * o.touchdown.omega_radps);
      DOUBLES_EQUAL(0.003 * rolling / std::hypot(rolling, 2.5), r.offset_m, 1e-14);
      DOUBLES_EQUAL(r.offset_m / kRadius, r.coefficient, 1e-15);
    }
  }
}

// Published for the 21 sets: 2.4 ± .85 mm (population sd), positive in all.
TEST(RollingFriction, IsPositiveInAll21Conditions) {
  const auto all = of(conditions(thesis::Version::as_printed));
  const RollingFrictionSummary s = summarize(all);
  LONGS_EQUAL(21, s.count);
  LONGS_EQUAL(21, s.positive);
  DOUBLES_EQUAL(2.4e-3, s.mean_m, 0.05e-3);
  DOUBLES_EQUAL(0.85e-3, s.scatter_m * std::sqrt(20.0 / 21.0), 0.005e-3);
  // One value for all 21 is well within the replicates' spread.
  CHECK_COMPARE(s.chi2_of_one_value, <, 31.4);  // 95 % of chi-square with 20
}

// Each input moved by its sd: d is linear in all but vy and e, where second order is below 1e-3 of the sd.
TEST(RollingFriction, TheSdIsTheRootOfTheInputsShares) {
  using Change = void (*)(Observation&);
  const Change changes[] = {[](Observation& o) { o.touchdown.vx_mps += o.touchdown_sd.vx_mps; },
                            [](Observation& o) { o.touchdown.vy_mps += o.touchdown_sd.vy_mps; },
                            [](Observation& o) { o.touchdown.omega_radps += o.touchdown_sd.omega_radps; },
                            [](Observation& o) { o.lift_off.vx_mps += o.lift_off_sd.vx_mps; },
                            [](Observation& o) { o.lift_off.omega_radps += o.lift_off_sd.omega_radps; },
                            [](Observation& o) { o.e += o.e_sd; }};
  for (const Observation& o : conditions()) {
    const auto r = rolling_friction(o, {.alpha = 0.55}, 0.02);
    double squares = 0.0;
    for (const Change change : changes) {
      Observation moved = o;
      change(moved);
      squares += std::pow(rolling_friction(moved, {.alpha = 0.55})->offset_m - r->offset_m, 2);
    }
    DOUBLES_EQUAL(std::sqrt(squares), r->offset_sd_m, 1e-3 * r->offset_sd_m);
    const double by_alpha = rolling_friction(o, {.alpha = 0.57})->offset_m - r->offset_m;
    DOUBLES_EQUAL(std::abs(by_alpha), r->offset_sd_alpha_m, 1e-12);
    DOUBLES_EQUAL(by_alpha / 0.02, r->offset_by_alpha_m, 1e-12);
    DOUBLES_EQUAL(r->offset_m / r->offset_sd_m, r->z_from_symmetry, 1e-12);
  }
}

TEST(RollingFriction, TheCoefficientDoesNotDependOnTheBallsDiameter) {
  const Observation o = conditions()[8];
  Observation scaled = o;  // as if photographed with a ball 2 % larger in mind
  for (Motion* m : {&scaled.touchdown, &scaled.lift_off}) {
    m->vx_mps *= 1.02;
    m->vy_mps *= 1.02;
  }
  const auto as_is = rolling_friction(o, {});
  const auto larger = rolling_friction(scaled, {.diameter_m = 1.02 * ball::kThesisDiameter_m});
  DOUBLES_EQUAL(as_is->coefficient, larger->coefficient, 1e-15);
  DOUBLES_EQUAL(1.02 * as_is->offset_m, larger->offset_m, 1e-17);
}

TEST(RollingFriction, WithoutSpreadEveryConditionCountsAlike) {
  auto observations = conditions();
  observations[0].touchdown_sd = observations[0].lift_off_sd = {};
  observations[0].e_sd = 0.0;
  const auto all = of(observations);
  DOUBLES_EQUAL(0.0, all[0].offset_sd_m, 0.0);
  CHECK(std::isinf(all[0].z_from_symmetry));
  const RollingFrictionSummary s = summarize(all);
  DOUBLES_EQUAL(s.mean_m, s.weighted_mean_m, 1e-17);
  LONGS_EQUAL(0, summarize({}).count);
}

TEST(RollingFriction, OfSeveralConditionsTheMeanIsWeightedByTheirVariances) {
  std::vector<RollingFriction> two(2);
  two[0].offset_m = 1e-3;
  two[1].offset_m = 4e-3;
  two[0].offset_sd_m = two[1].offset_sd_m = 0.5e-3;
  const RollingFrictionSummary alike = summarize(two);
  DOUBLES_EQUAL(2.5e-3, alike.weighted_mean_m, 1e-15);
  DOUBLES_EQUAL(0.5e-3 / std::sqrt(2.0), alike.weighted_mean_sd_m, 1e-15);
  DOUBLES_EQUAL(3e-3 / std::sqrt(2.0), alike.scatter_m, 1e-15);  // n - 1
  DOUBLES_EQUAL(18.0, alike.chi2_of_one_value, 1e-12);           // 2·(1.5/0.5)²
  two[1].offset_sd_m = 1e-3;
  const RollingFrictionSummary weighted = summarize(two);
  DOUBLES_EQUAL((4.0 * 1e-3 + 4e-3) / 5.0, weighted.weighted_mean_m, 1e-15);
  DOUBLES_EQUAL(1e-3 / std::sqrt(5.0), weighted.weighted_mean_sd_m, 1e-15);
}

TEST(RollingFriction, RefusesWhatIsOutOfRange) {
  const auto error = [](const std::function<void(Observation&)>& change) {
    Observation o = conditions()[0];
    change(o);
    return rolling_friction(o, {}).error();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(error([&](auto& o) { o.lift_off.omega_radps = nan; }) == InputError::not_finite);
  CHECK(error([&](auto& o) { o.lift_off_sd.vx_mps = -1.0; }) == InputError::not_finite);
  CHECK(error([&](auto& o) { o.touchdown.vy_mps = 1.0; }) == InputError::not_approaching);
  CHECK(error([&](auto& o) { o.e = 2.0; }) == InputError::restitution_out_of_range);
  CHECK_EQUAL(InputError::ball_out_of_range, rolling_friction(conditions()[0], {.alpha = 0.8}).error());
  CHECK_EQUAL(InputError::not_finite, rolling_friction(conditions()[0], {}, nan).error());
}
