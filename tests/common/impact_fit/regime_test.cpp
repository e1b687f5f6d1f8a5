#include "common/impact/fit/regime.hpp"

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "tests/common/impact_fit/check.hpp"
#include "tests/common/impact_fit/sessions.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::conditions;
using strobe::testing::random_source;

namespace {

const std::set<std::string> kSlide{"zero_17", "back_17", "back_22"};

struct Sets {
  std::set<std::string> predicted, measured;
  double least_sure = 1.0;  ///< smallest probability of what was predicted
};

Sets judge_all(const FitOptions& options, Spread spread) {
  const auto observations = conditions(thesis::Version::corrected, spread);
  const auto fitted = fit(observations, options);
  Sets out;
  for (const Observation& o : observations) {
    const auto j = classify_regime(o, options.model, *fitted, options.diameter_m);
    const bool slides = j->predicted == Regime::slides;
    if (slides) out.predicted.insert(o.name);
    if (j->measured == Regime::slides) out.measured.insert(o.name);
    CHECK(j->measured != Regime::unclear);
    out.least_sure = std::min(out.least_sure, slides ? *j->probability_slides : 1.0 - *j->probability_slides);
  }
  return out;
}

/// A fit whose parameters are known but for what is said of them.
ModelFit known(const ParameterValues& values, Parameter uncertain, double sd) {
  ModelFit out;
  for (std::size_t i = 0; i < kParameterCount; ++i) out.parameters[i].value = values[i];
  out.covariance.setZero();
  const auto at = static_cast<Eigen::Index>(index(uncertain));
  out.covariance(at, at) = sd * sd;
  return out;
}

}  // namespace

TEST_GROUP(Regimes){};

TEST(Regimes, All21ConditionsArePredictedAsMeasured) {
  for (const ReboundModel model : {ReboundModel::slide_roll, ReboundModel::grip, ReboundModel::grip_offset}) {
    for (const Spread spread : {Spread::replicate, Spread::mean}) {
      const Sets sets = judge_all(default_options(model), spread);
      CHECK_EQUAL(kSlide, sets.measured);
      if (model != ReboundModel::grip) CHECK_EQUAL(kSlide, sets.predicted);
    }
  }
}

// The border is nearest at zero -23: the mean grips, one shot in six of its spread would slide.
TEST(Regimes, OnlyTheConditionNextToTheBorderIsUncertain) {
  const Sets sets = judge_all(default_options(ReboundModel::grip_offset), Spread::replicate);
  CHECK_EQUAL(kSlide, sets.predicted);
  DOUBLES_EQUAL(0.82, sets.least_sure, 0.02);
}

// Without spin and offset: needed = (1 + e_x)·vx·alpha/(1 + alpha), available = mu·(1 + e)·|vy|.
TEST(Regimes, TheUncertaintiesAddUpAsTheFormulaSays) {
  Observation o;
  o.touchdown = {15.0, -6.0, 0.0};
  o.touchdown_sd = {0.3, 0.1, 5.0};
  o.lift_off = {9.0, 5.0, -250.0};
  o.lift_off_sd = {0.3, 0.1, 4.0};
  o.e = 0.8;
  o.e_sd = 0.02;
  const ParameterValues values{0.5, 0.1, 0.0, 2.5, 0.5};
  const ModelFit fitted = known(values, Parameter::mu, 0.03);
  const auto j = classify_regime(o, ReboundModel::grip_offset, fitted, 0.0651);
  DOUBLES_EQUAL(1.1 * 15.0 / 3.0, j->friction_needed_mps, 1e-12);
  DOUBLES_EQUAL(0.5 * 1.8 * 6.0, *j->friction_available_mps, 1e-12);
  const double sd =
      std::sqrt(std::pow(1.1 / 3.0 * 0.3, 2) + std::pow(1.1 / 3.0 * 0.03255 * 5.0, 2) +
                std::pow(0.5 * 1.8 * 0.1, 2) + std::pow(0.5 * 6.0 * 0.02, 2) + std::pow(1.8 * 6.0 * 0.03, 2));
  DOUBLES_EQUAL(sd, *j->margin_sd_mps, 1e-9);
  DOUBLES_EQUAL((5.5 - 5.4) / sd, *j->z, 1e-9);
  DOUBLES_EQUAL(9.0 - 0.03255 * 250.0, j->slip_lo_mps, 1e-12);
  const double slip_lo_sd = std::hypot(0.3, 0.03255 * 4.0);
  DOUBLES_EQUAL(slip_lo_sd, j->slip_lo_sd_mps, 1e-12);
  // Rolling off needs a third of 15 m/s, and 6 were lost.
  DOUBLES_EQUAL(5.0 - 6.0, j->shortfall_mps, 1e-12);
  DOUBLES_EQUAL(std::hypot(2.0 / 3.0 * 0.3, 0.3, 0.03255 * 5.0 / 3.0), j->shortfall_sd_mps, 1e-12);
  // With 4 lost it slid if it still slips by more than two sd.
  o.lift_off.vx_mps = 11.0;
  for (const auto& [sds, regime] : {std::pair(1.99, Regime::unclear), std::pair(2.01, Regime::slides)}) {
    o.lift_off.omega_radps = (sds * slip_lo_sd - 11.0) / 0.03255;
    CHECK(classify_regime(o, ReboundModel::grip_offset, fitted, 0.0651)->measured == regime);
  }
}

TEST(Regimes, TheProbabilityIsTheShareOfDraws) {
  auto source = random_source("probability of sliding");
  std::normal_distribution<double> normal;
  Observation o;
  o.touchdown = {15.0, -6.0, 20.0};
  o.touchdown_sd = {0.4, 0.2, 8.0};
  o.e = 0.8;
  o.e_sd = 0.03;
  const ParameterValues values{0.55, 0.1, 0.003, 2.5, 0.55};
  const auto j = classify_regime(o, ReboundModel::grip_offset, known(values, Parameter::e_x, 0.03), 0.0651);
  int slides = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    ParameterValues drawn = values;
    drawn[1] += 0.03 * normal(source);
    const Motion td{o.touchdown.vx_mps + 0.4 * normal(source), o.touchdown.vy_mps + 0.2 * normal(source),
                    o.touchdown.omega_radps + 8.0 * normal(source)};
    const auto r = rebound_of(ReboundModel::grip_offset, drawn, 0.0651, td, o.e + 0.03 * normal(source));
    slides += r->regime == Regime::slides ? 1 : 0;
  }
  // Sampling is worth .0035; products of the inputs' errors, a few hundredths of an sd, bend the normal.
  DOUBLES_EQUAL(slides / static_cast<double>(kDraws), *j->probability_slides, 0.02);
}

TEST(Regimes, WithoutAnyUncertaintyTheAnswerIsSure) {
  Observation o;
  o.touchdown = {15.0, -2.0, 0.0};
  o.e = 0.8;
  const auto j =
      classify_regime(o, ReboundModel::grip, known({0.5, 0.1, 0.0, 2.5, 0.5}, Parameter::mu, 0.0), 0.0651);
  CHECK(std::isinf(*j->z) && *j->z > 0.0);
  DOUBLES_EQUAL(1.0, *j->probability_slides, 0.0);
}

// Faster than rolling, the contact point slips backward: friction drives the ball forward, and it slides if it
// still slips backward at lift-off.
TEST(Regimes, ATopspinFasterThanRollingIsClassifiedByItsOwnDirection) {
  Observation o;
  o.touchdown = {5.0, -8.0, -400.0};
  o.lift_off = {6.0, 6.0, -350.0};  // slip 6.0 - 11.4 m/s
  o.lift_off_sd = {0.1, 0.1, 2.0};
  o.e = 0.75;
  const ModelFit fitted = known({0.07, 0.0, 0.0, 2.5, 0.55}, Parameter::mu, 0.0);
  CHECK_EQUAL(Regime::slides, classify_regime(o, ReboundModel::grip, fitted, 0.0651)->measured);
  o.lift_off = {7.9, 6.0, -242.0};  // rolls, and vx has changed by more than rolling needs
  const ModelFit rough = known({0.3, 0.0, 0.0, 2.5, 0.55}, Parameter::mu, 0.0);
  CHECK_EQUAL(Regime::grips, classify_regime(o, ReboundModel::grip, rough, 0.0651)->measured);
  o.lift_off = {7.7, 6.0, -242.0};  // less than rolling needs, but no slip beyond two sd
  o.lift_off_sd.omega_radps = 10.0;
  CHECK_EQUAL(Regime::unclear, classify_regime(o, ReboundModel::grip, fitted, 0.0651)->measured);
}

TEST(Regimes, RefusesWhatTheModelRefuses) {
  Observation o;
  o.touchdown = {15.0, 2.0, 0.0};
  const ModelFit fitted = known({0.5, 0.1, 0.0, 2.5, 0.5}, Parameter::mu, 0.0);
  CHECK_EQUAL(InputError::not_approaching, classify_regime(o, ReboundModel::grip, fitted, 0.0651).error());
}

// Near the border noise makes the one regime look like the other.
TEST(Regimes, NoShotIsSaidToSlideBesideAMeasuredGripNorTheOtherWayRound) {
  auto source = random_source("regimes agree");
  int contradicted = 0, unclear = 0;
  for (int i = 0; i < 30; ++i) {
    const testing::Session session = testing::draw_session(testing::SessionKind::mixed, source);
    const auto fitted = fit(session.shots, session.options);
    for (const Observation& o : session.shots) {
      const auto r = classify_regime(o, session.options.model, *fitted, session.options.diameter_m);
      const bool sure = r->regime != Regime::unclear && r->measured != Regime::unclear;
      if (sure) CHECK_TRUE(r->regime == r->measured);
      contradicted += r->shortfall_mps <= 0.0 && r->predicted == Regime::slides ? 1 : 0;
      unclear += r->regime == Regime::unclear ? 1 : 0;
    }
  }
  std::printf("contradicted %d, unclear %d ", contradicted, unclear);
  CHECK(contradicted > 0);
}

TEST(Regimes, OfTwoThatContradictTheUnsureOneIsUnclear) {
  // Without spin and offset gripping takes vx·alpha/(1 + alpha) = 5 m/s off, of mu·J.
  Observation o;
  o.touchdown = {15.0, -6.0, 0.0};
  o.e = 0.8;
  o.lift_off = {9.9, 4.8, -300.0};  // .1 m/s more than rolling takes: measured as gripping
  const double needed = 15.0 * 0.5 / 1.5, impulse = 1.8 * 6.0;
  const auto classified = [&](double margin_sds, double measured_sd) {
    const double mu_sd = 0.01;
    const ParameterValues values{needed / impulse - margin_sds * mu_sd, 0.0, 0.0, 2.5, 0.5};
    o.lift_off_sd.vx_mps = measured_sd;
    const auto r =
        classify_regime(o, ReboundModel::grip, known(values, Parameter::mu, mu_sd), ball::kThesisDiameter_m);
    CHECK_TRUE(r->predicted == Regime::slides);
    return std::pair(r->regime, r->measured);
  };
  CHECK_TRUE(classified(1.0, 0.01) == std::pair(Regime::unclear, Regime::grips));
  CHECK_TRUE(classified(3.0, 0.10) == std::pair(Regime::slides, Regime::unclear));
  CHECK_TRUE(classified(1.0, 0.10) == std::pair(Regime::unclear, Regime::unclear));
  CHECK_TRUE(classified(3.0, 0.01) == std::pair(Regime::unclear, Regime::grips));
}
