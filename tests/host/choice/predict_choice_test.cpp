#include "host/commands/predict/predict_choice.hpp"

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using frontier::Row;

namespace {

Row row(std::string method, std::string parameter, double cost_us, double error) {
  return {.study = "lift_off",
          .method = std::move(method),
          .parameter = std::move(parameter),
          .cost_us = cost_us,
          .error = error,
          .error_unit = "of v_td",
          .note = ""};
}

/// Costs are made up, so that no machine's figures matter; errors are no less than the methods' own.
std::vector<Row> rows() {
  return {row("rigid", "", 0.01, 0.6),
          row("grip", "ex=0.35", 0.02, 0.4),
          row("grip_offset", "ex=0.35;offset_mm=1.5", 0.03, 0.3),
          row("pulse_exact", "", 0.5, 0.6),
          row("ode", "tolerance=0.001", 9.0, 0.01),
          row("ode", "tolerance=1e-06", 14.0, 1e-5),
          row("ode", "tolerance=1e-09", 30.0, 1e-8),
          row("ode", "tolerance=1e-12", 80.0, 1e-11),
          row("ode_rk4", "steps=50", 12.0, 1e-3),
          row("bullet", "steps=10", 0.001, 1e-9),
          row("grip", "", 0.001, 1e-9)};
}

MeasuredModels measured() { return measured_models(rows(), {}); }

PredictInput thesis_input() {
  PredictInput in;
  in.touchdown = {15.62, -6.71, 2.6};
  in.e = 0.86;
  return in;
}

HostTime no_clock() { return {}; }

Result<ImpactChoice> choose(const frontier::Requirement& requirement, const std::string& model = "",
                            const PredictInput& in = thesis_input()) {
  return choose_impact(measured(), requirement, model, in, no_clock);
}

/// The contact's mechanics to 1e-12, with the material that all models were given.
impact::Motion exact(const PredictInput& in) {
  impact::ContactCoefficients c = in.contact;
  c.e = in.e;
  c.mu = *in.mu;
  c.dwell_s = in.dwell_time_ms / 1e3;
  const ball::Ball ball{.diameter_m = in.diameter_m, .mass_kg = in.mass_kg, .alpha = *in.alpha};
  return impact::simulate(ball, in.touchdown, c,
                          {.method = impact::ContactMethod::dormand_prince, .tolerance = 1e-12})
      .value()
      .lift_off;
}

double error_of(const ImpactChoice& choice) {
  const impact::Motion got = choice.prediction.rebound.lift_off;
  const impact::Motion want = exact(choice.input);
  const double spin = choice.input.diameter_m / 2 * (got.omega_radps - want.omega_radps);
  return std::hypot(got.vx_mps - want.vx_mps, got.vy_mps - want.vy_mps, spin) /
         std::hypot(choice.input.touchdown.vx_mps, choice.input.touchdown.vy_mps);
}

struct Draw {
  std::mt19937_64 random;
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  PredictInput impact() {
    PredictInput in;
    const double speed = std::exp(between(0.0, std::log(50.0))), angle = between(0.1, 1.45);
    in.touchdown = {speed * std::cos(angle), -speed * std::sin(angle), between(-1.0, 1.0) * speed / 0.033};
    in.e = between(0.5, 0.9);
    in.mu = between(0.3, 0.9);
    in.alpha = between(0.5, 0.66);
    return in;
  }
};

}  // namespace

TEST_GROUP(PredictChoice){};

TEST(PredictChoice, KnowsOnlyMethodsThatItCanRun) {
  LONGS_EQUAL(rows().size() - 2, measured().rows.size());
  const auto grip = input_for(row("grip_offset", "ex=0.35;offset_mm=1.5", 1.0, 1.0), {});
  CHECK_EQUAL("grip", grip->model);
  DOUBLES_EQUAL(0.35, grip->e_x, 0.0);
  DOUBLES_EQUAL(1.5, grip->offset_mm, 0.0);
  DOUBLES_EQUAL(0.0, input_for(row("grip", "ex=0.35", 1.0, 1.0), {})->offset_mm, 0.0);
  LONGS_EQUAL(50, input_for(row("ode_rk4", "steps=50", 1.0, 1.0), {})->integration.steps);
  CHECK(!input_for(row("grip_offset", "ex=0.35", 1.0, 1.0), {}));
  CHECK(!input_for(row("ode", "tolerance=small", 1.0, 1.0), {}));
  CHECK(!input_for(row("ode", "", 1.0, 1.0), {}));
}

TEST(PredictChoice, GivesEveryModelTheMaterialOfTheContactsMechanics) {
  const auto choice = choose({.tolerance = 0.9, .deadline_us = 1.0});
  CHECK_EQUAL("rigid", choice->taken.row.method);
  DOUBLES_EQUAL(impact::ContactCoefficients{}.mu, *choice->input.mu, 0.0);
  DOUBLES_EQUAL(impact::kContactAlpha, *choice->input.alpha, 0.0);
}

TEST(PredictChoice, ChecksOnTheImpactAskedForWhereThereIsTime) {
  const auto choice = choose({.tolerance = 0.9, .deadline_us = {}});
  CHECK_EQUAL("rigid", choice->taken.row.method);
  const double error = error_of(*choice);
  // The check's own error, 1 %, is counted in and may act either way.
  CHECK(*choice->taken.error_estimate >= error);
  DOUBLES_EQUAL(error + 0.01, *choice->taken.error_estimate, 0.01);
  CHECK(*choice->within_tolerance);
  DOUBLES_EQUAL(9.01, choice->expected_cost_us, 1e-12);
}

TEST(PredictChoice, LeavesTheCheckOutWhereTheDeadlineHasNoTimeForIt) {
  const auto choice = choose({.tolerance = 0.9, .deadline_us = 9.0});
  CHECK(!choice->taken.error_estimate);
  CHECK(!choice->within_tolerance);
  DOUBLES_EQUAL(0.01, choice->expected_cost_us, 0.0);
}

// A promise about this impact holds for it, whichever way it came about.
TEST(PredictChoice, PromisesWhatItKnowsOfThisImpact) {
  MeasuredModels quick{.rows = {row("rigid", "", 0.01, 0.6), row("return_mapping", "steps=16", 0.7, 0.05),
                                row("collocation", "tolerance=0.001", 1.3, 1e-3),
                                row("collocation", "tolerance=1e-06", 2.5, 1e-6)},
                       .ranges = {}};
  const auto choose_in = [&](double tolerance, std::optional<double> deadline_us) {
    return choose_impact(quick, {.tolerance = tolerance, .deadline_us = deadline_us}, "", thesis_input(),
                         no_clock);
  };
  const auto checked = choose_in(0.05, {});
  CHECK_EQUAL("return_mapping", checked->taken.row.method);
  CHECK_EQUAL("collocation", checked->taken.checked_by->method);
  CHECK(PromiseBasis::check == checked->promise.basis);
  CHECK(error_of(*checked) <= checked->promise.error);
  CHECK(checked->promise.error < 0.01);  // far below the worst of all contacts

  const auto controlled = choose_in(1e-3, 2.0);
  CHECK_EQUAL("tolerance=0.001", controlled->taken.row.parameter);
  CHECK(impact::ContactMethod::collocation == controlled->input.integration.method);
  CHECK(PromiseBasis::error_control == controlled->promise.basis);
  DOUBLES_EQUAL(1e-3, controlled->promise.error, 0.0);
  CHECK(error_of(*controlled) <= controlled->promise.error);

  const auto unknown = choose_in(0.05, 1.0);
  CHECK_EQUAL("return_mapping", unknown->taken.row.method);
  CHECK(PromiseBasis::worst_measured == unknown->promise.basis);
  DOUBLES_EQUAL(0.05, unknown->promise.error, 0.0);
}

TEST(PredictChoice, TakesTheCheckWhereItShowsMoreErrorThanAllowed) {
  MeasuredModels optimistic{.rows = rows(), .ranges = {}};
  optimistic.rows = measured_models(optimistic.rows, {}).rows;
  optimistic.rows[0].error = 1e-3;  // rigid is off by percents here
  const frontier::Requirement requirement{.tolerance = 1e-2, .deadline_us = {}};
  const auto choice = choose_impact(optimistic, requirement, "", thesis_input(), no_clock);
  LONGS_EQUAL(1, choice->replaced.size());
  CHECK_EQUAL("rigid", choice->replaced[0].row.method);
  CHECK(*choice->replaced[0].error_estimate > 1e-2);
  CHECK_EQUAL("ode", choice->taken.row.method);
  CHECK(error_of(*choice) <= 1e-2);
  // The one taken instead was checked in turn.
  CHECK(*choice->within_tolerance);

  const auto restricted = choose_impact(optimistic, requirement, "rigid", thesis_input(), no_clock);
  CHECK_EQUAL("rigid", restricted->taken.row.method);
  CHECK(!*restricted->within_tolerance);
}

TEST(PredictChoice, KeepsToTheModelGiven) {
  const auto choice = choose({.tolerance = 0.02, .deadline_us = {}}, "ode");
  CHECK_EQUAL("tolerance=0.001", choice->taken.row.parameter);
  const auto refused = choose({.tolerance = 0.02, .deadline_us = {}}, "grip");
  CHECK_EQUAL(
      "no method meets 2%; the most exact of all is grip_offset ex=0.35;offset_mm=1.5 (30% of v_td in 0.03 "
      "us)",
      refused.error().message);
}

TEST(PredictChoice, SaysWhatIsWrongWithTheImpact) {
  PredictInput away = thesis_input();
  away.touchdown.vy_mps = 1.0;
  CHECK_EQUAL("vy must be negative: the ball must move towards the surface",
              choose({.tolerance = 0.02, .deadline_us = {}}, "", away).error().message);
}

TEST(PredictChoice, NamesWhatLiesOutsideOfWhatWasMeasured) {
  MeasuredModels narrow = measured();
  narrow.ranges = {{.study = "lift_off", .quantity = "e", .lowest = 0.5, .highest = 0.85},
                   {.study = "lift_off", .quantity = "v_td_mps", .lowest = 1.0, .highest = 60.0},
                   {.study = "lift_off", .quantity = "theta_in_deg", .lowest = 30.0, .highest = 85.0}};
  const auto choice =
      choose_impact(narrow, {.tolerance = 0.5, .deadline_us = {}}, "", thesis_input(), no_clock);
  LONGS_EQUAL(2, choice->outside.size());
  CHECK_EQUAL("theta_in_deg", choice->outside[0]);
  CHECK_EQUAL("e", choice->outside[1]);
}

TEST(PredictChoice, TakesNoSpinForOneBetweenThoseMeasured) {
  MeasuredModels narrow = measured();
  narrow.ranges = {{.study = "lift_off", .quantity = "spin_ratio", .lowest = 0.01, .highest = 0.9}};
  PredictInput in = thesis_input();
  const frontier::Requirement requirement{.tolerance = 0.5, .deadline_us = {}};
  in.touchdown.omega_radps = 0.0;
  LONGS_EQUAL(0, choose_impact(narrow, requirement, "", in, no_clock)->outside.size());
  in.touchdown.omega_radps = 500.0;  // R omega is 16.3 m/s of 17
  LONGS_EQUAL(1, choose_impact(narrow, requirement, "", in, no_clock)->outside.size());
}

TEST(PredictChoice, TakesAMirroredImpactForTheSame) {
  MeasuredModels narrow = measured();
  narrow.ranges = {{.study = "lift_off", .quantity = "omega_radps", .lowest = 0.0, .highest = 10.0}};
  PredictInput left = thesis_input();
  left.touchdown.vx_mps = -left.touchdown.vx_mps;
  left.touchdown.omega_radps = -left.touchdown.omega_radps;
  const frontier::Requirement requirement{.tolerance = 0.5, .deadline_us = {}};
  LONGS_EQUAL(0, choose_impact(narrow, requirement, "", thesis_input(), no_clock)->outside.size());
  LONGS_EQUAL(0, choose_impact(narrow, requirement, "", left, no_clock)->outside.size());
}

// The rows' errors are far above the integrations' own, so that what they promise holds; a check that says
// "within" must then be right against an integration to 1e-12, and no requirement may be overrun.
TEST(PredictChoice, OnAnyImpactKeepsTheDeadlineAndNeverCallsAnErrorWithinThatIsNot) {
  constexpr std::uint64_t kSeed = 11;
  Draw draw{std::mt19937_64(kSeed)};
  int checked = 0;
  for (int i = 0; i < 300; ++i) {
    const PredictInput in = draw.impact();
    frontier::Requirement requirement{.tolerance = std::pow(10.0, draw.between(-7.0, -0.1)),
                                      .deadline_us = {}};
    if (i % 3 == 0) requirement.deadline_us = draw.between(1.0, 150.0);
    const auto choice = choose(requirement, "", in);
    if (!choice) continue;
    CHECK(choice->taken.row.error <= *requirement.tolerance);
    if (requirement.deadline_us) CHECK(choice->expected_cost_us <= *requirement.deadline_us);
    if (!choice->within_tolerance) continue;
    ++checked;
    CHECK(*choice->within_tolerance);
    CHECK_TEXT(error_of(*choice) <= *requirement.tolerance, choice->taken.row.method.c_str());
  }
  CHECK(checked > 100);
}
