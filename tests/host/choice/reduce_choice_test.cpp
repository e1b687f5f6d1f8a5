#include "host/commands/reduce/reduce_choice.hpp"

#include <string>

#include "tests/common/reduction/simulated_shot.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using frontier::Row;

namespace {

Row row(std::string study, std::string method, std::string parameter, double cost_us, double error) {
  return {.study = std::move(study),
          .method = std::move(method),
          .parameter = std::move(parameter),
          .cost_us = cost_us,
          .error = error,
          .error_unit = "of the readouts' scales",
          .note = ""};
}

std::vector<Row> reduce_rows() {
  return {row("reduce", "two-point", "", 5.0, 0.05),
          row("reduce", "best", "effects=none", 6.0, 0.05),
          row("reduce", "best", "effects=auto", 8.0, 0.03),
          row("reduce", "best", "effects=all;covariance=yes", 1.0, 0.03),
          row("reduce_estimated", "two-point", "", 30.0, 0.05),
          row("reduce_estimated", "best", "effects=auto", 50.0, 0.03),
          row("reduce_fine", "two-point", "", 5.0, 0.01),
          row("reduce_fine", "best", "effects=gravity+drag", 8.0, 0.006)};
}

reduction::Frame frame(test::Setup setup = {}) {
  test::Random random(3);
  return test::photograph({}, setup, random);
}

test::Setup of_sd(double sd_m, bool stated = true) {
  test::Setup setup;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = sd_m;
  setup.state_noise = stated;
  return setup;
}

HostTime standing_clock() { return {}; }

Result<EstimatorChooser> chooser(frontier::Requirement requirement, std::string estimator = "",
                                 std::string flight = "") {
  return EstimatorChooser::make(
      reduce_rows(), {},
      {.requirement = requirement, .estimator = std::move(estimator), .flight = std::move(flight)},
      standing_clock);
}

ChosenReadout reduced(frontier::Requirement requirement, const reduction::Frame& of) {
  return chooser(requirement).value().reduce(of).value();
}

}  // namespace

TEST_GROUP(ReduceChoice){};

TEST(ReduceChoice, TellsFramesApartByTheirNoise) {
  CHECK_EQUAL("reduce", study_for(frame()));
  CHECK_EQUAL("reduce_fine", study_for(frame(of_sd(3e-5))));
  CHECK_EQUAL("reduce_estimated", study_for(frame(of_sd(3e-5, false))));
  reduction::Frame partly = frame();
  partly.equator_sd_rad.reset();
  CHECK_EQUAL("reduce_estimated", study_for(partly));
}

TEST(ReduceChoice, CountsOnlyTheEstimatorsOwnPartOfTheError) {
  // sqrt(5² - 3²) = 4 %: two-point and the flight without effects add it, the best adds nothing.
  const auto wide = reduced({.tolerance = 0.0401, .deadline_us = {}}, frame(of_sd(1.2e-4)));
  CHECK_EQUAL("two-point", wide.readout.method);
  DOUBLES_EQUAL(0.04, wide.choice.row.error, 1e-15);
  const auto narrow = reduced({.tolerance = 0.0399, .deadline_us = {}}, frame(of_sd(1.2e-4)));
  CHECK_EQUAL("best", narrow.readout.method);
  DOUBLES_EQUAL(0.0, narrow.choice.row.error, 0.0);
}

// 3 % of noise hides a bias of 0.8 % (sqrt(1² - 0.6²)), which is there all the same.
TEST(ReduceChoice, TakesABiasThatNoiseHidesForWhatItIsWithoutNoise) {
  std::vector<Row> biased = reduce_rows();
  biased.push_back(row("reduce", "best", "effects=gravity", 7.0, 0.03));
  biased.push_back(row("reduce_fine", "best", "effects=gravity", 7.0, 0.01));
  const auto own = [&](double tolerance) {
    const EstimatorRequirement requirement{
        .requirement = {.tolerance = tolerance, .deadline_us = {}}, .estimator = "best", .flight = ""};
    return EstimatorChooser::make(biased, {}, requirement, standing_clock)->reduce(frame())->choice.row;
  };
  CHECK_EQUAL("effects=gravity", own(0.0081).parameter);
  DOUBLES_EQUAL(0.008, own(0.0081).error, 1e-15);
  CHECK_EQUAL("effects=auto", own(0.0079).parameter);
}

TEST(ReduceChoice, GivesTheReadoutThatTheEstimatorGives) {
  const auto chosen = reduced({.tolerance = 0.005, .deadline_us = {}}, frame(of_sd(3e-5)));
  const auto plain = reduction::reduce(frame(of_sd(3e-5)), reduction::Estimator::best,
                                       {.effects = flight::Effects{true, true, false}});
  CHECK_EQUAL(chosen.readout.value, plain->value);
  CHECK_EQUAL(chosen.readout.sd, plain->sd);
}

TEST(ReduceChoice, GivesWayToTheBestWhereTheReadoutsOwnSdIsBeyondTheTolerance) {
  // By hand, half a millimetre: two-point's spins and times are off by several percent, the best's by less.
  const auto chosen = reduced({.tolerance = 0.045, .deadline_us = {}}, frame());
  CHECK(chosen.choice.replaced.has_value());
  CHECK_EQUAL("best", chosen.readout.method);
  DOUBLES_EQUAL(13.0, chosen.choice.expected_cost_us, 0.0);
  const auto no_time = reduced({.tolerance = 0.045, .deadline_us = 12.0}, frame());
  CHECK(!no_time.choice.replaced);
  CHECK_EQUAL("two-point", no_time.readout.method);
  CHECK(no_time.choice.noise_beyond_tolerance);
}

TEST(ReduceChoice, SaysWhatNoiseNoEstimatorMends) {
  const auto noisy = reduced({.tolerance = 0.001, .deadline_us = {}}, frame());
  CHECK(noisy.choice.noise_beyond_tolerance);
  CHECK(noisy.choice.noise->share > 0.001);
  const auto calm = reduced({.tolerance = 0.02, .deadline_us = {}}, frame(of_sd(1e-5)));
  CHECK(!calm.choice.noise_beyond_tolerance);
  CHECK(calm.choice.noise->share > 0.0);
}

TEST(ReduceChoice, KeepsToWhatTheUserStates) {
  const auto two_point = chooser({.tolerance = {}, .deadline_us = 100.0}, "two-point");
  CHECK_EQUAL("two-point", two_point->reduce(frame())->readout.method);
  const auto automatic = chooser({.tolerance = 0.9, .deadline_us = {}}, "", "auto");
  CHECK_EQUAL("effects=auto", automatic->reduce(frame())->choice.row.parameter);
}

TEST(ReduceChoice, RefusesWhatNoKindOfFrameAllowsAndElseTheFrameConcerned) {
  CHECK_EQUAL(
      "no method meets 0.1% and 2 us; the fastest of all is two-point (4% of the readouts' scales in 5 us); "
      "exact "
      "enough the fastest is best effects=auto (0% of the readouts' scales in 8 us)",
      chooser({.tolerance = 1e-3, .deadline_us = 2.0}).error().message);
  const auto mixed = chooser({.tolerance = 1e-3, .deadline_us = 20.0});
  CHECK(mixed->reduce(frame()).has_value());
  const auto refused = mixed->reduce(frame(of_sd(5e-4, false)));
  CHECK(!refused);
  CHECK_EQUAL(
      "no method meets 0.1% and 20 us; the fastest of all is two-point (4% of the readouts' scales in 30 "
      "us); "
      "exact enough the fastest is best effects=auto (0% of the readouts' scales in 50 us)",
      refused.error().message);
}

TEST(ReduceChoice, NamesWhatLiesOutsideOfWhatWasMeasured) {
  const std::vector<frontier::Range> ranges{{"reduce", "images_per_leg", 3.0, 4.0},
                                            {"reduce", "v_td_mps", 10.0, 30.0}};
  const auto narrow = EstimatorChooser::make(
      reduce_rows(), ranges,
      {.requirement = {.tolerance = 0.9, .deadline_us = {}}, .estimator = "", .flight = ""}, standing_clock);
  const auto chosen = narrow->reduce(frame());
  LONGS_EQUAL(1, chosen->choice.outside.size());
  CHECK_EQUAL("images_per_leg", chosen->choice.outside[0]);
}

TEST(ReduceChoice, ReckonsWithMoreImagesThanWereMeasured) {
  const std::vector<frontier::Range> ranges{{"reduce", "images_per_leg", 4.0, 4.0}};
  const auto best_in = [&](double deadline_us) {
    const EstimatorRequirement requirement{
        .requirement = {.tolerance = 0.001, .deadline_us = deadline_us}, .estimator = "", .flight = ""};
    return EstimatorChooser::make(reduce_rows(), ranges, requirement, standing_clock)->reduce(frame());
  };
  // The best takes 8 us with four images a leg, thus 10 us with five.
  CHECK(!best_in(9.9));
  CHECK(best_in(10.1).has_value());
  DOUBLES_EQUAL(10.0, best_in(10.1)->choice.row.cost_us, 1e-12);
}

TEST(ReduceChoice, TakesNoFrameForOneThatIsNot) {
  const auto any = chooser({.tolerance = 0.9, .deadline_us = {}});
  CHECK_EQUAL(reduction::reduce({}, reduction::Estimator::best).error().message,
              any->reduce({}).error().message);
}
