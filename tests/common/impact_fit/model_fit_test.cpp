#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "common/impact/fit/model_fit.hpp"
#include "tests/common/impact_fit/check.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::conditions;
using strobe::testing::true_rebounds;

namespace {

constexpr ParameterValues kSearched{0.5, 0.12, 0.0028, 2.0, 0.56};

/// 1e-6 of the values: derivatives are good to 1e-10 and the sum of squares to its rounding, whose root the
/// parameters follow.
void check_recovered(const FitOptions& options, const ParameterValues& truth) {
  const auto fitted = fit(true_rebounds(conditions(), truth), options);
  CHECK(fitted.has_value());
  for (std::size_t i = 0; i < kParameterCount; ++i)
    if (options.free[i]) DOUBLES_EQUAL(truth[i], fitted->parameters[i].value, 1e-6 * truth[i]);
  CHECK_COMPARE(fitted->statistics.rms_vx_mps, <, 1e-7);
}

FitOptions all_free(ReboundModel model) {
  FitOptions out = default_options(model);
  for (std::size_t i = 0; i < kParameterCount; ++i)
    out.free[i] = has_parameter(model, static_cast<Parameter>(i));
  return out;
}

FitError error_of(std::vector<Observation> observations, const FitOptions& options) {
  const auto fitted = fit(observations, options);
  CHECK(!fitted.has_value());
  CHECK(!message(fitted.error(), observations).empty());
  return fitted.error().error;
}

}  // namespace

TEST_GROUP(ModelFit){};

TEST(ModelFit, FindsTheParametersThatMadeTheRebounds) {
  check_recovered(all_free(ReboundModel::slide_roll), {0.5, 0.0, 0.0, 2.5, 0.6});
  check_recovered(all_free(ReboundModel::grip), {0.5, 0.12, 0.0, 2.5, 0.6});
  check_recovered(all_free(ReboundModel::grip_offset), kSearched);
}

TEST(ModelFit, FindsTheParametersByTheStatedSdToo) {
  FitOptions options = all_free(ReboundModel::grip_offset);
  options.weighting = Weighting::stated_sd;
  check_recovered(options, kSearched);
}

// The truth does not depend on where the fit starts.
TEST(ModelFit, StartsFarOffLeadToTheSameFit) {
  const auto observations = conditions();
  const FitOptions options = default_options(ReboundModel::grip_offset);
  const auto usual = fit(observations, options);
  FitOptions far = options;
  far.start = {3.0, -0.9, 0.03, 90.0, 0.55};
  const auto other = fit(observations, far);
  DOUBLES_EQUAL(usual->chi2, other->chi2, 1e-9 * usual->chi2);
  for (std::size_t i = 0; i < 3; ++i)
    DOUBLES_EQUAL(usual->parameters[i].value, other->parameters[i].value, 1e-4 * *usual->parameters[i].sd);
}

// Sums of squares near the least are flat: no neighbour, along any axis, is better.
TEST(ModelFit, NoNeighbourOfTheFitIsBetter) {
  const auto observations = conditions();
  const FitOptions options = default_options(ReboundModel::grip_offset);
  const auto fitted = fit(observations, options);
  for (std::size_t i = 0; i < 4; ++i) {
    for (const double step : {-1e-3, 1e-3, -0.1, 0.1}) {
      FitOptions moved = options;
      moved.start = fitted->values();
      moved.start[i] += step * *fitted->parameters[i].sd;
      moved.free = {};
      CHECK_COMPARE(fit(observations, moved)->chi2, >, fitted->chi2);
    }
  }
}

TEST(ModelFit, NothingFreeJudgesTheModelAsItStands) {
  FitOptions options = default_options(ReboundModel::slide_roll);
  options.free = {};
  const auto fitted = fit(conditions(thesis::Version::as_printed), options);
  LONGS_EQUAL(42, fitted->dof);
  DOUBLES_EQUAL(0.88, fitted->statistics.rms_vx_mps, 0.01);
  DOUBLES_EQUAL(30.0, fitted->statistics.rms_omega_radps, 0.5);
  CHECK(fitted->covariance.isZero(0.0));
}

// Published: rms .67 m/s and 27 rad/s with e_x .081 at alpha .70. No ball has that much inertia: at the
// bound of 2/3 the fit is .02 m/s and .6 rad/s worse.
TEST(ModelFit, TheGripsInertiaPressesAgainstTheThinShells) {
  const auto fitted = fit(conditions(thesis::Version::as_printed), all_free(ReboundModel::grip));
  const FittedParameter& alpha = fitted->parameters[index(Parameter::alpha)];
  CHECK_EQUAL(ParameterStatus::at_upper_bound, alpha.status);
  DOUBLES_EQUAL(2.0 / 3.0, alpha.value, 0.0);
  CHECK(!alpha.sd.has_value());
  CHECK_COMPARE(*alpha.limit, <, 2.0 / 3.0);
  CHECK_COMPARE(*alpha.limit, >, 0.6);
  DOUBLES_EQUAL(0.686, fitted->statistics.rms_vx_mps, 0.003);
  DOUBLES_EQUAL(27.59, fitted->statistics.rms_omega_radps, 0.1);
  DOUBLES_EQUAL(0.081, fitted->parameters[index(Parameter::e_x)].value, 0.005);
}

// Published: mu .567, e_x .089, d 2.5 mm: .495 m/s and 15.4 rad/s, 8 and 11 of 21 within one sd. That was
// another weighting of the two; the sum of squares of this one cannot be more than there.
TEST(ModelFit, AConstantOffsetFitsAsPublished) {
  FitOptions options = default_options(ReboundModel::grip_offset);
  options.free[index(Parameter::offset_reference_mps)] = false;
  options.start[index(Parameter::offset_reference_mps)] = 1e-9;  // all of the 21 roll along +x
  const auto fitted = fit(conditions(thesis::Version::as_printed), options);
  DOUBLES_EQUAL(0.567, fitted->parameters[0].value, 0.01);
  DOUBLES_EQUAL(0.089, fitted->parameters[1].value, 0.01);
  DOUBLES_EQUAL(0.0025, fitted->parameters[2].value, 0.0001);
  DOUBLES_EQUAL(0.495, fitted->statistics.rms_vx_mps, 0.011);
  DOUBLES_EQUAL(15.4, fitted->statistics.rms_omega_radps, 0.25);
  LONGS_EQUAL(8, fitted->statistics.within_sd_vx);
  LONGS_EQUAL(11, fitted->statistics.within_sd_omega);
  const double radius = options.diameter_m / 2.0;
  CHECK_COMPARE(fitted->chi2, <, 21.0 * (0.495 * 0.495 + std::pow(radius * 15.4, 2)));
}

TEST(ModelFit, AnOffsetOddInTheRollingFitsBetterThanAConstantOne) {
  const auto fitted =
      fit(conditions(thesis::Version::as_printed), default_options(ReboundModel::grip_offset));
  CHECK(converged(fitted->termination));
  DOUBLES_EQUAL(kFittedToThesis.mu, fitted->parameters[0].value, 0.001);
  DOUBLES_EQUAL(kFittedToThesis.e_x, fitted->parameters[1].value, 0.001);
  DOUBLES_EQUAL(kFittedToThesis.offset_m, fitted->parameters[2].value, 0.00005);
  DOUBLES_EQUAL(kFittedToThesis.offset_reference_mps, fitted->parameters[3].value, 0.05);
  DOUBLES_EQUAL(0.42, fitted->statistics.rms_vx_mps, 0.005);
  DOUBLES_EQUAL(14.3, fitted->statistics.rms_omega_radps, 0.05);
  LONGS_EQUAL(12, fitted->statistics.within_sd_vx);
  LONGS_EQUAL(13, fitted->statistics.within_sd_omega);
}

TEST(ModelFit, BoundsAreKeptWhereTheTruthLiesBeyondThem) {
  auto observations = true_rebounds(conditions(), {0.5, 0.0, -0.002, 2.5, 0.55});
  const auto fitted = fit(observations, default_options(ReboundModel::grip_offset));
  const FittedParameter& offset = fitted->parameters[index(Parameter::offset_m)];
  CHECK_EQUAL(ParameterStatus::at_lower_bound, offset.status);
  DOUBLES_EQUAL(0.0, offset.value, 0.0);
  CHECK(offset.limit.has_value() && *offset.limit > 0.0 && *offset.limit < 0.002);
}

TEST(ModelFit, FrictionIsUndeterminedWhereAllGripButNotLessThanTheyNeed) {
  auto observations = conditions();
  std::erase_if(observations, [](const Observation& o) { return o.spin != "top"; });
  observations = true_rebounds(observations, {5.0, 0.1, 0.003, 2.5, 0.55});
  FitOptions options = default_options(ReboundModel::grip_offset);
  options.free[index(Parameter::offset_reference_mps)] = false;
  const auto fitted = fit(observations, options);
  const FittedParameter& mu = fitted->parameters[index(Parameter::mu)];
  CHECK_EQUAL(ParameterStatus::undetermined, mu.status);
  CHECK(!mu.sd.has_value());
  double most = 0.0;
  for (const Observation& o : observations)
    most =
        std::max(most, (o.touchdown.vx_mps - o.lift_off.vx_mps) / (o.lift_off.vy_mps - o.touchdown.vy_mps));
  DOUBLES_EQUAL(most, *mu.limit, 1e-6);
  DOUBLES_EQUAL(0.003, fitted->parameters[index(Parameter::offset_m)].value, 1e-8);
}

TEST(ModelFit, RefusesMoreParametersThanNumbers) {
  const std::vector<Observation> one{conditions()[0]};
  CHECK_EQUAL(FitError::underdetermined, error_of(one, default_options(ReboundModel::grip_offset)));
  FitOptions two = default_options(ReboundModel::grip);
  CHECK_EQUAL(FitError::underdetermined, error_of(one, two));  // none to spare for the level of the sd
  two.scale = CovarianceScale::stated;
  two.free[index(Parameter::alpha)] = true;
  CHECK_EQUAL(FitError::underdetermined, error_of(one, two));
  CHECK_EQUAL(FitError::no_observations, error_of({}, two));
}

TEST(ModelFit, SaysWhichParametersCannotBeToldApart) {
  // Gripping without spin at one angle: two numbers tell of two parameters only.
  std::vector<Observation> observations(6, conditions()[4]);
  const FitOptions options = default_options(ReboundModel::grip_offset);
  const auto fitted = fit(observations, options);
  CHECK(!fitted.has_value());
  CHECK_EQUAL(FitError::not_identifiable, fitted.error().error);
  CHECK(has_parameter(options.model, fitted.error().parameter));
}

TEST(ModelFit, RefusesWhatIsNotANumberOrOutOfRange) {
  const FitOptions options = default_options(ReboundModel::grip_offset);
  const auto with = [](const std::function<void(Observation&)>& change) {
    auto observations = conditions();
    change(observations[5]);
    return observations;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(error_of(with([&](auto& o) { o.lift_off.vx_mps = nan; }), options) == FitError::invalid_observation);
  CHECK(error_of(with([&](auto& o) { o.touchdown.omega_radps = INFINITY; }), options) ==
        FitError::invalid_observation);
  CHECK(error_of(with([](auto& o) { o.e = 1.1; }), options) == FitError::invalid_observation);
  CHECK(error_of(with([](auto& o) { o.lift_off_sd.vx_mps = -1.0; }), options) == FitError::invalid_sd);
  CHECK(error_of(with([&](auto& o) { o.e_sd = nan; }), options) == FitError::invalid_sd);
  FitOptions by_sd = options;
  by_sd.weighting = Weighting::stated_sd;
  const auto weightless = with([](auto& o) { o.lift_off_sd.omega_radps = 0.0; });
  CHECK_EQUAL(FitError::invalid_sd, error_of(weightless, by_sd));
  CHECK(fit(weightless, options).has_value());

  FitOptions wrong = options;
  wrong.start[index(Parameter::alpha)] = 0.7;
  CHECK_EQUAL(FitError::value_out_of_bounds, error_of(conditions(), wrong));
  wrong = options;
  wrong.start[index(Parameter::mu)] = nan;
  CHECK_EQUAL(FitError::value_out_of_bounds, error_of(conditions(), wrong));
  wrong = default_options(ReboundModel::slide_roll);
  wrong.free[index(Parameter::e_x)] = true;
  CHECK_EQUAL(FitError::parameter_not_in_model, error_of(conditions(), wrong));
  wrong = options;
  wrong.vx_weight = 0.0;
  CHECK_EQUAL(FitError::invalid_options, error_of(conditions(), wrong));
}

// Whatever is not refused gives numbers.
TEST(ModelFit, HugeAndSubnormalInputsAreRefusedOrGiveNumbers) {
  using Field = double& (*)(Observation&);
  const Field fields[] = {[](Observation& o) -> double& { return o.touchdown.vx_mps; },
                          [](Observation& o) -> double& { return o.touchdown.vy_mps; },
                          [](Observation& o) -> double& { return o.touchdown.omega_radps; },
                          [](Observation& o) -> double& { return o.lift_off.vx_mps; },
                          [](Observation& o) -> double& { return o.lift_off.omega_radps; },
                          [](Observation& o) -> double& { return o.touchdown_sd.vy_mps; },
                          [](Observation& o) -> double& { return o.lift_off_sd.vx_mps; },
                          [](Observation& o) -> double& { return o.e_sd; }};
  for (const Field field : fields) {
    for (const double value : {1e308, -1e308, 1e40, -1e40, 5e-324, -5e-324, 1e-200, -1e-200, 1e29}) {
      for (const Weighting weighting : {Weighting::equal, Weighting::stated_sd}) {
        auto observations = conditions();
        field(observations[7]) = value;
        FitOptions options = default_options(ReboundModel::grip_offset);
        options.weighting = weighting;
        const auto fitted = fit(observations, options);
        if (!fitted) continue;
        for (const FittedParameter& p : fitted->parameters) CHECK(std::isfinite(p.value));
        CHECK(std::isfinite(fitted->chi2) && fitted->covariance.allFinite());
      }
    }
  }
}

TEST(ModelFit, NamesTheObservationThatIsWrong) {
  auto observations = conditions();
  observations[5].e = 1.1;
  const auto fitted = fit(observations, default_options(ReboundModel::grip));
  CHECK_EQUAL("zero_60: e must be from 0 to 1", message(fitted.error(), observations));
}

TEST(ModelFit, ScoresLeaveOutWhatHasNoSd) {
  auto observations = conditions();
  observations[0].lift_off_sd = {};
  observations[0].touchdown_sd = {};
  observations[0].e_sd = 0.0;
  const auto fitted = fit(observations, default_options(ReboundModel::grip_offset));
  CHECK(!fitted->comparisons[0].z_vx.has_value());
  CHECK(!fitted->comparisons[0].z_omega_with_inputs.has_value());
  CHECK(std::isfinite(fitted->statistics.rms_z_vx));
}

namespace {

/// The tables' last digits are worth .01 m/s, .01 rad/s and .01 of e. Draws within half of each move these
/// figures by at most .0017 m/s and .094 rad/s (sd of 100 draws); three of those.
constexpr double kVx = 0.005, kOmega = 0.28;

void check_figures(const FitOptions& options, CrossValidationGroup by, double vx_mps, double omega_radps) {
  const auto v = leave_one_group_out(conditions(), options, by);
  CHECK(v.has_value());
  DOUBLES_EQUAL(vx_mps, v->statistics.rms_vx_mps, kVx);
  DOUBLES_EQUAL(omega_radps, v->statistics.rms_omega_radps, kOmega);
  LONGS_EQUAL(21, v->statistics.count);
}

FitOptions grip_with_alpha() {
  FitOptions out = default_options(ReboundModel::grip);
  out.free[index(Parameter::alpha)] = true;
  return out;
}

}  // namespace

TEST_GROUP(LeavingOut){};

TEST(LeavingOut, EachSpinPredictedFromTheOtherTwo) {
  check_figures(default_options(ReboundModel::slide_roll), CrossValidationGroup::spin, 0.899, 30.82);
  check_figures(grip_with_alpha(), CrossValidationGroup::spin, 0.686, 29.48);
  check_figures(default_options(ReboundModel::grip_offset), CrossValidationGroup::spin, 0.436, 17.24);
}

TEST(LeavingOut, EachConditionPredictedFromTheOthers) {
  check_figures(default_options(ReboundModel::slide_roll), CrossValidationGroup::series, 0.916, 30.12);
  check_figures(grip_with_alpha(), CrossValidationGroup::series, 0.713, 28.86);
  check_figures(default_options(ReboundModel::grip_offset), CrossValidationGroup::series, 0.474, 16.78);
}

TEST(LeavingOut, APredictionComesFromAFitThatHasNotSeenIt) {
  const auto observations = conditions();
  const FitOptions options = default_options(ReboundModel::grip_offset);
  const auto v = leave_one_group_out(observations, options, CrossValidationGroup::spin);
  LONGS_EQUAL(3, v->groups.size());
  std::set<std::size_t> seen;
  for (const HeldOutGroup& group : v->groups) {
    std::vector<Observation> others;
    for (const Observation& o : observations)
      if (o.spin != group.group) others.push_back(o);
    const auto alone = fit(others, options);
    for (std::size_t i = 0; i < 4; ++i)
      DOUBLES_EQUAL(alone->parameters[i].value, group.fit.parameters[i].value, 0.0);
    for (const std::size_t i : group.observations) {
      CHECK_EQUAL(group.group, observations[i].spin);
      seen.insert(i);
    }
  }
  LONGS_EQUAL(21, seen.size());
}

TEST(LeavingOut, ATrueModelPredictsWhatItHasNotSeen) {
  const ParameterValues truth{0.5, 0.1, 0.003, 2.5, 0.55};
  const auto v = leave_one_group_out(true_rebounds(conditions(), truth),
                                     default_options(ReboundModel::grip_offset), CrossValidationGroup::spin);
  CHECK_COMPARE(v->statistics.rms_vx_mps, <, 1e-6);
  CHECK_COMPARE(v->statistics.rms_omega_radps, <, 1e-4);
}

TEST(LeavingOut, WorksWithinOneSpinToo) {
  FitOptions options = default_options(ReboundModel::grip_offset);
  options.free[index(Parameter::offset_reference_mps)] = false;
  for (const char* spin : {"zero", "top", "back"}) {
    const auto observations = of_spin(conditions(), spin);
    LONGS_EQUAL(7, observations.size());
    const auto v = leave_one_group_out(observations, options, CrossValidationGroup::series);
    CHECK(v.has_value());
    const auto whole = fit(observations, options);
    CHECK_COMPARE(v->statistics.rms_vx_mps, >, whole->statistics.rms_vx_mps);
  }
}

TEST(LeavingOut, NeedsTwoGroups) {
  const auto v = leave_one_group_out(of_spin(conditions(), "top"), default_options(ReboundModel::slide_roll),
                                     CrossValidationGroup::spin);
  CHECK_EQUAL(FitError::underdetermined, v.error().error);
}

TEST(LeavingOut, NamesTheObservationThatIsWrong) {
  auto observations = conditions();
  observations[20].e = -0.2;
  const auto v =
      leave_one_group_out(observations, default_options(ReboundModel::grip), CrossValidationGroup::spin);
  LONGS_EQUAL(20, v.error().observation);
}
