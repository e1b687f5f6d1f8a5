// Predictions of published bounces against arithmetic by hand and figures that were computed apart from this code.
#include "host/bounces/prediction.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>

#include "common/flight/gravity.hpp"
#include "common/impact/closed_form/turf.hpp"
#include "host/bounces/report.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::bounces;

namespace {

const published::Bounces& shipped() {
  static const published::Bounces bounces = [] {
    auto loaded = published::load_bounces(STROBE_BOUNCES_FOLDER);
    if (!loaded) throw std::runtime_error(loaded.error().message);
    return *std::move(loaded);
  }();
  return bounces;
}

Case case_of(const char* set, const std::string& row) {
  for (const Case& c : cases_of(shipped(), *shipped().set(set)))
    if (c.bounce.name == row) return c;
  throw std::runtime_error("there is no " + row);
}

Case cross(const std::string& row) { return case_of("cross_2002_table_2", row); }

Prediction predicted(const Case& c, Model model) {
  const auto prediction = predict(c, model);
  if (!prediction) throw std::runtime_error(prediction.error().message);
  return *prediction;
}

}  // namespace

TEST_GROUP(PublishedPrediction){};

// Computed once with another program from the printed rows: the contact mechanics' spins and speeds, the rigid model's
// spins. They were stated to a tenth and a hundredth.
TEST(PublishedPrediction, TheRowsOfCross2002AreThoseComputedElsewhere) {
  struct Stated {
    const char* row;
    double omega_radps, vx_mps, rigid_omega_radps;
  };
  for (const Stated& s : {Stated{"wood_45", -56.8, 1.55, -48.9}, Stated{"emery_45", -49.8, 1.59, -47.6},
                          Stated{"rebound_ace_45", -48.5, 1.55, -46.3}}) {
    const Prediction mechanics = predicted(cross(s.row), Model::mechanics);
    DOUBLES_EQUAL(s.omega_radps, mechanics.lift_off.omega_radps, 0.06);
    DOUBLES_EQUAL(s.vx_mps, mechanics.lift_off.vx_mps, 0.006);
    DOUBLES_EQUAL(s.rigid_omega_radps, predicted(cross(s.row), Model::rigid).lift_off.omega_radps, 0.06);
  }
  DOUBLES_EQUAL(-29.7, predicted(cross("wood_20"), Model::mechanics).lift_off.omega_radps, 0.1);
  DOUBLES_EQUAL(-68.4, predicted(cross("emery_20"), Model::mechanics).lift_off.omega_radps, 0.06);
  DOUBLES_EQUAL(-61.7, predicted(cross("rebound_ace_20"), Model::mechanics).lift_off.omega_radps, 0.06);
}

TEST(PublishedPrediction, FrictionIsTheImpulseRatioOfTheRowThatTellsIt) {
  // wood, 20 degrees: (3.72 cos 20 - 3.09 cos 19.2)/(3.72 sin 20 + 3.09 sin 19.2).
  const double deg = std::numbers::pi / 180.0;
  const double mu = (3.72 * std::cos(20 * deg) - 3.09 * std::cos(19.2 * deg)) /
                    (3.72 * std::sin(20 * deg) + 3.09 * std::sin(19.2 * deg));
  DOUBLES_EQUAL(mu, cross("wood_20").mu(), 1e-4);
  DOUBLES_EQUAL(mu, cross("wood_45").mu(), 1e-4);
  CHECK(cross("wood_20").tells_its_own_friction());
  CHECK(!cross("wood_45").tells_its_own_friction());
  CHECK(predicted(cross("wood_20"), Model::known).vx_is_given);
  CHECK(
      !predicted(cross("rebound_ace_20"), Model::known).vx_is_given);  // its friction was measured elsewhere
  DOUBLES_EQUAL(0.9, case_of("cross_2010", "golf_pad").mu(), 0.0);
}

// A ball that slides has omega = -(vx_TD - vx_LO)/(alpha·R), with alpha 2/3; moving vx_TD and vx_LO, which give mu, moves
// it by their sds over alpha·R. e does not matter.
TEST(PublishedPrediction, TheSdOfASlidingRowIsThatOfItsChangeOfSpeed) {
  const Case c = cross("wood_20");
  const double arm = 2.0 / 3.0 * 0.033;
  const Prediction rigid = predicted(c, Model::rigid);
  DOUBLES_EQUAL(-(c.bounce.vx_td_mps.value - c.bounce.vx_lo_mps->value) / arm, rigid.lift_off.omega_radps,
                1e-9);
  const double by_speeds = std::hypot(c.bounce.vx_td_mps.sd, c.bounce.vx_lo_mps->sd) / arm;
  DOUBLES_EQUAL(std::hypot(by_speeds, c.bounce.omega_lo_radps->sd), rigid.residual.omega_radps->sd, 1e-9);
  DOUBLES_EQUAL(0.0, rigid.residual.vx_mps->sd, 1e-9);  // vx is what it was computed from
}

// A ball that rolls off has R·omega = -vx_TD/(1 + alpha): of the inputs vx_TD alone matters.
TEST(PublishedPrediction, TheSdOfARollingRowIsThatOfItsSpeedAtTouchdown) {
  const Case c = cross("emery_45");
  const Prediction rigid = predicted(c, Model::rigid);
  DOUBLES_EQUAL(std::hypot(c.bounce.vx_td_mps.sd * 0.6 / 0.033, c.bounce.omega_lo_radps->sd),
                rigid.residual.omega_radps->sd, 1e-9);
  DOUBLES_EQUAL(std::hypot(c.bounce.vx_td_mps.sd * 0.6, c.bounce.vx_lo_mps->sd), rigid.residual.vx_mps->sd,
                1e-9);
}

TEST(PublishedPrediction, AnErrorThatTakesRestitutionBeyondOneIsNoError) {
  Case c = cross("wood_45");
  c.bounce.vy_lo_mps->value = -c.bounce.vy_td_mps.value;
  for (const Model model : kModels) CHECK(predict(c, model).has_value());
  Case solid = case_of("cross_2014", "granite_16");  // e .988, whose dashpot is next to none
  for (const Model model : kModels) CHECK(predict(solid, model).has_value());
}

TEST(PublishedPrediction, TheWeightAlongAnInclinedSurfaceSpeedsTheBallUp) {
  Case inclined = cross("emery_45"), level = inclined;
  level.bounce.incline_deg.reset();
  level.friction_row->incline_deg.reset();
  DOUBLES_EQUAL(flight::kStandardGravity_mps2 * std::sin(std::numbers::pi / 4.0), weight_of(inclined.bounce).along_mps2, 1e-12);
  DOUBLES_EQUAL(flight::kStandardGravity_mps2 * std::cos(std::numbers::pi / 4.0), weight_of(inclined.bounce).into_mps2, 1e-12);
  DOUBLES_EQUAL(0.0, weight_of(level.bounce).along_mps2, 0.0);
  // A gripping ball takes on 1/(1 + alpha) to all of g·sin(45)·5 ms = .035 m/s, depending on when it grips.
  const double faster =
      predicted(inclined, Model::known).lift_off.vx_mps - predicted(level, Model::known).lift_off.vx_mps;
  CHECK(faster > 0.0);
  CHECK(faster < 0.04);
  DOUBLES_EQUAL(predicted(level, Model::mechanics).lift_off.vx_mps,
                predicted(inclined, Model::mechanics).lift_off.vx_mps, 0.0);
}

TEST(PublishedPrediction, ASlidingRowKeepsItsChangeOfSpeedUnderItsWeight) {
  // mu is then larger, as friction had to work against the weight; vx comes out as measured but for the first instants,
  // in which the tangential spring still holds (1 % of the change).
  const Case c = cross("wood_20");
  const Prediction known = predicted(c, Model::known);
  CHECK(known.mu > c.mu() + 0.01);
  DOUBLES_EQUAL(c.bounce.vx_lo_mps->value, known.lift_off.vx_mps, 0.006);
}

TEST(PublishedPrediction, WhatTheModelsRefuseIsToldWithTheBouncesName) {
  Case c = cross("wood_45");
  c.friction_row.reset();
  c.friction.row.clear();
  c.friction.mu = -1.0;
  const auto refused = predict(c, Model::rigid);
  CHECK(!refused);
  CHECK_EQUAL("wood_45: mu must not be negative", refused.error().message);
}

TEST(PublishedPrediction, AModelIsNotValidWhereItsBallOrGroundIsNotTheRows) {
  const auto against = [](const Case& c, Model model) { return std::string(not_valid(c, model)); };
  const Case tennis = cross("wood_45"), superball = case_of("cross_2014", "granite_37");
  for (const Model model : {Model::rigid, Model::grip, Model::mechanics, Model::known})
    CHECK_EQUAL("", against(tennis, model));
  CHECK_EQUAL("ball is hollow", against(tennis, Model::elastic));
  CHECK_EQUAL("", against(superball, Model::elastic));
  CHECK_EQUAL("constants of a tennis ball", against(superball, Model::grip));
  CHECK_EQUAL("normal speed outside 2-16 m/s", against(cross("wood_20"), Model::known));  // 1.27 m/s
  CHECK_EQUAL("", against(cross("wood_20"), Model::rigid));
  CHECK_EQUAL("pad gives way", against(case_of("cross_2010", "golf_pad"), Model::elastic));
  for (const Model model : kModels)
    CHECK_EQUAL("strings give way", against(case_of("lindsey_strings", "nxt_52"), model));
}

// Only there: on turf `known` is the rigid body on the plane that tilts, and on a hard surface it is not.
TEST(PublishedPrediction, TheContactPlaneTiltsOnTurfAlone) {
  Case golf = case_of("cross_2010", "golf_granite");
  const impact::Motion touchdown{golf.bounce.vx_td_mps.value, golf.bounce.vy_td_mps.value, 0.0};
  const ball::Ball ball{.diameter_m = golf.ball.diameter_m, .mass_kg = golf.ball.mass_kg, .alpha = 0.4};
  const double e = *golf.bounce.restitution();
  const double tilted = impact::rigid_on_turf(ball, touchdown, e, golf.mu())->lift_off.vx_mps;
  CHECK(std::abs(predicted(golf, Model::known).lift_off.vx_mps - tilted) > 0.01);
  golf.friction.ground = published::Ground::turf;
  DOUBLES_EQUAL(tilted, predicted(golf, Model::known).lift_off.vx_mps, 1e-12);
  CHECK_EQUAL("ground yields", std::string(not_valid(golf, Model::rigid)));
  CHECK_EQUAL("", std::string(not_valid(golf, Model::known)));
}

// At .0947 friction an alumina sphere slides at 49.694° (kappa·tan/mu = 10.8, above 4·chi - 1 = 5.1), and every model has
// vx = vx_TD - mu·(1 + e)·|vy|; at 9.5° a rigid ball rolls off with 5/7 of vx and an elastic one does not.
TEST(PublishedPrediction, AnElasticBallReturnsSlipWhereARigidOneRolls) {
  const Case slides = case_of("kharaz_2001", "speed_50"), grips = case_of("kharaz_2001", "speed_09");
  const double vx = 2.9741 - slides.mu() * 1.98 * 2.5228;
  DOUBLES_EQUAL(vx, predicted(slides, Model::elastic).lift_off.vx_mps, 2e-4);
  DOUBLES_EQUAL(vx, predicted(slides, Model::rigid).lift_off.vx_mps, 2e-4);
  DOUBLES_EQUAL(5.0 / 7.0 * 0.6434, predicted(grips, Model::rigid).lift_off.vx_mps, 1e-12);
  CHECK(predicted(grips, Model::elastic).lift_off.vx_mps < 0.68 * 0.6434);
}

TEST_GROUP(PublishedBalance){};

TEST(PublishedBalance, AlphaIsTheChangeOfSpeedOverThatOfSpin) {
  // emery, 20 degrees: 3.53 cos 20 - 2.24 cos 27.2 = 1.3248 m/s; R·78.5 = 2.5905 m/s. Falling along the surface at
  // g·sin 70 = 9.218 m/s² for 5 ms adds .0461.
  const Case c = cross("emery_20");
  DOUBLES_EQUAL(1.3248 / 2.5905, balance_of(c, false)->alpha.value, 1e-4);
  DOUBLES_EQUAL((1.3248 + 0.0461) / 2.5905, balance_of(c, true)->alpha.value, 1e-4);
}

TEST(PublishedBalance, ExIsTheSlipReturned) {
  // emery, 20 degrees: (78.5·.033 - 1.9923)/3.3171; wood slides: negative.
  DOUBLES_EQUAL((2.5905 - 1.9923) / 3.3171, balance_of(cross("emery_20"), false)->e_x, 1e-4);
  CHECK(balance_of(cross("wood_20"), false)->e_x < -0.4);
}

TEST(PublishedBalance, TheOffsetVanishesWithTheAlphaThatFitsWithoutIt) {
  Case c = cross("emery_20");
  c.ball.alpha.value = balance_of(c, true)->alpha.value;
  DOUBLES_EQUAL(0.0, balance_of(c, true)->offset_m.value, 1e-12);
  c.ball.alpha.value += 0.01;  // a heavier rim asks for a couple that drives it: the force behind the centre
  CHECK(balance_of(c, true)->offset_m.value < 0.0);
}

TEST(PublishedBalance, SpeedsThatWereNotPublishedHaveNone) {
  CHECK(!balance_of(case_of("lindsey_strings", "nxt_52"), true));
}

TEST(PublishedBalance, OneAlphaIsWeightedByTheSds) {
  // 0.4 ± 0.1 and 0.6 ± 0.2: weights 100 and 25.
  const published::Measured alphas[] = {{0.4, 0.1}, {0.6, 0.2}};
  const MeanAlpha mean = mean_of(alphas);
  DOUBLES_EQUAL(0.44, mean.alpha.value, 1e-12);
  DOUBLES_EQUAL(1.0 / std::sqrt(125.0), mean.alpha.sd, 1e-12);
  DOUBLES_EQUAL(0.16 + 0.64, mean.chi_square, 1e-12);  // (.04/.1)², (.16/.2)²
}

TEST_GROUP(PublishedAgreement){};

TEST(PublishedAgreement, IsTheRootMeanSquareOfWhatIsPredicted) {
  const auto rows = rows_of(shipped(), *shipped().set("cross_2002_table_2"));
  CHECK(rows.has_value());
  const Agreement rigid = agreement_of(*rows, Model::rigid);
  LONGS_EQUAL(6, rigid.omega_count);
  LONGS_EQUAL(3, rigid.vx_count);  // the 20-degree rows tell the friction
  double square = 0.0;
  for (const Row& row : *rows) square += std::pow(row.predictions[0].residual.omega_radps->value, 2);
  DOUBLES_EQUAL(std::sqrt(square / 6.0), rigid.omega_rms_radps, 1e-12);
}

TEST(PublishedAgreement, CountsWhatLiesWithin95Percent) {
  const auto rows = rows_of(shipped(), *shipped().set("kharaz_2001"));
  CHECK(rows.has_value());
  int within = 0;
  for (const Row& row : *rows) {
    const Prediction& p = row.predictions[static_cast<std::size_t>(Model::elastic)];
    if (p.residual.vx_mps && !p.vx_is_given && std::abs(p.residual.vx_mps->value) <= 1.96 * p.residual.vx_mps->sd)
      ++within;
    if (p.residual.omega_radps && std::abs(p.residual.omega_radps->value) <= 1.96 * p.residual.omega_radps->sd)
      ++within;
  }
  LONGS_EQUAL(within, agreement_of(*rows, Model::elastic).covered);
  LONGS_EQUAL(7, agreement_of(*rows, Model::elastic).vx_count);  // one tells the friction
}

TEST(PublishedAgreement, TheFigureHoldsEveryBounceOfItsKindOfBall) {
  std::vector<Row> rows;
  for (const char* set : {"cross_2002_table_2", "cross_2010"}) {
    const auto of_set = rows_of(shipped(), *shipped().set(set));
    CHECK(of_set.has_value());
    rows.insert(rows.end(), of_set->begin(), of_set->end());
  }
  const figures::Figure figure = spin_figure(rows);
  LONGS_EQUAL(2, figure.panels.size());
  const auto& tennis = figure.panels[0].series;
  LONGS_EQUAL(1 + 5, tennis.size());  // the line of agreement, then the models
  LONGS_EQUAL(6, tennis[1].points.size());
  LONGS_EQUAL(8, figure.panels[1].series[4].points.size());
  LONGS_EQUAL(1, spin_figure({rows.front()}).panels.size());  // no panel without points
  DOUBLES_EQUAL(34.9, tennis[1].points[0].x, 0.0);
  DOUBLES_EQUAL(-rows[0].predictions[0].lift_off.omega_radps, tennis[1].points[0].y, 0.0);
}
