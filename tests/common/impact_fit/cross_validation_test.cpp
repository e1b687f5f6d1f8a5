#include "common/impact/fit/cross_validation.hpp"

#include <set>

#include "tests/common/impact_fit/check.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::conditions;
using strobe::testing::true_rebounds;

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
