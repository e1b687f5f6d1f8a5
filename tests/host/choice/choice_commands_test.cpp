#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::testing;

namespace {

constexpr const char* kFrame = STROBE_SOURCE_DIR "/tests/fuzz/corpus/reduction_frame_json/every_key.json";

// Made up, so that no machine's figures matter.
constexpr const char* kFrontier =
    "study,method,parameter,cost_us,error,error_unit,note\n"
    "lift_off,rigid,,0.01,0.6,of v_td,\n"
    "lift_off,grip_offset,ex=0.35;offset_mm=1.5,0.03,0.3,of v_td,frontier\n"
    "lift_off,ode,tolerance=0.001,9,0.01,of v_td,frontier\n"
    "lift_off,ode,tolerance=1e-06,14,1e-5,of v_td,frontier\n"
    "lift_off,ode,tolerance=1e-09,30,1e-8,of v_td,frontier\n"
    "reduce,two-point,,5,0.05,of the readouts' scales,frontier\n"
    "reduce,best,effects=auto,8,0.03,of the readouts' scales,frontier\n"
    "reduce_estimated,best,effects=auto,50,0.03,of the readouts' scales,frontier\n";

}  // namespace

TEST_GROUP(ChoiceCommands) {
  TemporaryFolder folder;
  std::string frontier;

  void setup() override {
    frontier = (folder.path() / "frontier.csv").string();
    write_text(frontier, kFrontier);
  }

  CompletedProcess run(std::vector<std::string> arguments, bool chooses = true) const {
    arguments.insert(arguments.begin(), STROBE_PROGRAM);
    if (chooses) arguments.insert(arguments.end(), {"--frontier", frontier});
    return run_program(std::move(arguments));
  }

  CompletedProcess predict(std::vector<std::string> more, bool chooses = true) const {
    more.insert(more.begin(), {"predict", "--vx", "15.62", "--vy", "-6.71", "--e", "0.86"});
    return run(std::move(more), chooses);
  }
};

TEST(ChoiceCommands, PredictSaysWhatItTookAndWhy) {
  const CompletedProcess run = predict({"--tolerance", "0.1%", "--deadline-us", "50", "--json"});
  const auto json = json_of(run);
  CHECK_EQUAL("ode", json["inputs"]["model"]);
  CHECK_EQUAL(1e-6, json["inputs"]["tolerance"]);
  const auto& choice = json["choice"];
  CHECK_EQUAL("tolerance=1e-06", choice["parameter"]);
  CHECK_EQUAL(1e-5, choice["expected_error"]);
  CHECK_EQUAL(14.0, choice["expected_cost_us"]);
  CHECK_EQUAL(44.0, choice["total_expected_cost_us"]);
  CHECK_EQUAL("the cheapest of 5 methods that meets 0.1% and 50 us", choice["reason"]);
  CHECK(choice["error_estimate"].get<double>() < 1e-3);
  CHECK(choice["within_tolerance"].get<bool>());
  CHECK_EQUAL("check", choice["promised_by"]);
  CHECK_EQUAL(choice["error_estimate"], choice["promised_error"]);
  CHECK(run.err.starts_with("strobe: predict: took "));
}

TEST(ChoiceCommands, PredictGivesTheSameBytesEachTime) {
  const CompletedProcess once = predict({"--tolerance", "1e-6", "--json"});
  const CompletedProcess again = predict({"--tolerance", "1e-6", "--json"});
  CHECK(!once.out.empty());
  CHECK_EQUAL(once.out, again.out);
}

TEST(ChoiceCommands, PredictTellsItsChoiceInWords) {
  check_prints(predict({"--deadline-us", "10"}),
               {"chosen ode tolerance=0.001: the most exact of 5 methods that meets 10 us; at most 1% of "
                "v_td in 9 us as measured\n",
                "not checked on this impact: no time for a more exact run\n",
                "promised for this impact: 1%, by the method's own error control\n"});
}

TEST(ChoiceCommands, PredictSaysWithHowManyStepsItIntegrated) {
  write_text(frontier,
             "study,method,parameter,cost_us,error,error_unit,note\n"
             "lift_off,ode_rk4,steps=50,12,0.001,of v_td,\n");
  const CompletedProcess run = predict({"--tolerance", "1%", "--json"});
  const auto inputs = parse_json_lines(run.out).at(0)["inputs"];
  CHECK_EQUAL("rk4", inputs["integrator"]);
  CHECK_EQUAL(50, inputs["steps"]);
  CHECK(!inputs.contains("tolerance"));
}

TEST(ChoiceCommands, PredictRefusesWhatNothingMeetsAndNamesTheNearest) {
  check_refused(predict({"--tolerance", "0.1%", "--deadline-us", "5"}),
                "predict: no method meets 0.1% and 5 us; in time the most exact is grip_offset "
                "ex=0.35;offset_mm=1.5 (30% of v_td in 0.03 us); exact enough the fastest is ode "
                "tolerance=1e-06 (0.001% of v_td in 14 us)");
}

TEST(ChoiceCommands, PredictRefusesWhatDoesNotGoTogether) {
  check_refused(predict({"--tolerance", "5"}),
                "predict: --tolerance: '5' is more than 100%; did you mean 5%?");
  check_refused(predict({"--deadline-us", "-1"}), "predict: --deadline-us must be above 0");
  check_refused(predict({"--tolerance", "1%", "--ode-tolerance", "1e-6"}),
                "predict: --ode-tolerance is chosen with --tolerance or --deadline-us: leave it out");
  check_refused(predict({"--tolerance", "1%", "--model", "rigid", "--samples", "4"}),
                "predict: --samples and --trajectory need --model ode");
  check_refused(predict({}), "predict: --frontier is for --tolerance and --deadline-us");
}

TEST(ChoiceCommands, PredictRefusesOptionsOfAnotherModel) {
  check_refused(predict({"--kt-ratio", "2"}, false), "predict: --kt-ratio is for --model ode, not grip");
  check_refused(predict({"--model", "rigid", "--ex", "0.1"}, false),
                "predict: --ex is for --model grip, not rigid");
  check_refused(predict({"--mass-kg", "0.06"}, false),
                "predict: --mass-kg is for --model pulse or ode, not grip");
  LONGS_EQUAL(0, predict({"--model", "pulse", "--mass-kg", "0.06"}, false).status->code);
}

TEST(ChoiceCommands, PredictNamesLineAndColumnOfAWrongFrontier) {
  write_text(frontier, "study,method,parameter,cost_us,error,error_unit,note\na,b,,x,1,u,\n");
  check_refused(predict({"--tolerance", "1%"}), "predict: " + frontier + ":2: cost_us: 'x' is not a number");
}

TEST(ChoiceCommands, PredictFailsWhereTheModelAskedForMissesTheToleranceOnThisImpact) {
  write_text(frontier,
             "study,method,parameter,cost_us,error,error_unit,note\n"
             "lift_off,rigid,,0.01,0.001,of v_td,\n"
             "lift_off,ode,tolerance=1e-06,14,1e-5,of v_td,\n");
  const CompletedProcess run = predict({"--tolerance", "1%", "--model", "rigid", "--json"});
  LONGS_EQUAL(1, run.status->code);
  const auto json = parse_json_lines(run.out).at(0);
  CHECK(!json["choice"]["within_tolerance"].get<bool>());
  CHECK(run.err.find("strobe: predict: rigid misses the tolerance on this impact\n") != std::string::npos);
  const auto instead = json_of(predict({"--tolerance", "1%", "--json"}));
  CHECK_EQUAL("ode", instead["choice"]["method"]);
  CHECK_EQUAL("rigid", instead["choice"]["replaced"][0]["method"]);
}

TEST(ChoiceCommands, ReduceSaysWhatItTookAndWhatNoiseIsLeft) {
  const CompletedProcess run = this->run({"reduce", kFrame, "--tolerance", "0.5%", "--json"});
  const auto json = json_of(run);
  CHECK_EQUAL("best", json["method"]);
  CHECK_EQUAL("effects=auto", json["choice"]["parameter"]);
  CHECK_EQUAL(0.0, json["choice"]["expected_error"]);
  CHECK(json["choice"]["noise_beyond_tolerance"].get<bool>());
  CHECK(run.err.starts_with("strobe: reduce: took "));
  check_prints(
      this->run({"reduce", kFrame, "--tolerance", "0.5%"}),
      {"chosen best effects=auto: the cheapest of 2 methods that meets 0.5%; adds 0% of the readouts' "
       "scales in 8 us as measured\n",
       "the photograph's own noise is beyond the tolerance: sd of "});
}

TEST(ChoiceCommands, ReduceAddsNothingButTheChoice) {
  const CompletedProcess plain = run({"reduce", kFrame, "--json"}, false);
  const CompletedProcess chosen = run({"reduce", kFrame, "--deadline-us", "10", "--json"});
  const auto end = chosen.out.find(",\"choice\":");
  CHECK(end != std::string::npos);
  CHECK_EQUAL(plain.out, chosen.out.substr(0, end) + "}\n");
}

TEST(ChoiceCommands, ReduceRefusesWhatNoEstimatorMeets) {
  check_refused(
      run({"reduce", kFrame, "--deadline-us", "1"}),
      "reduce: no method meets 1 us; the fastest of all is two-point (4% of the readouts' scales in "
      "5 us)");
  check_refused(
      run({"reduce", kFrame, "--tolerance", "1%", "--estimator", "two-point"}),
      "reduce: no method meets 1%; the most exact of all is two-point (4% of the readouts' scales in "
      "5 us)");
  check_refused(run({"reduce", kFrame, "--tolerance", "much"}),
                "reduce: --tolerance: 'much' is not a tolerance; write one as 0.5% or 5e-3");
}

TEST(ChoiceCommands, NoiseFromResidualsTakesStatedSdsForRelativeWeights) {
  const auto believed = json_of(run({"reduce", kFrame, "--json"}, false));
  const auto weights = json_of(run({"reduce", kFrame, "--noise", "residuals", "--json"}, false));
  CHECK_TRUE(believed["residual_ratio"].is_number());
  CHECK_TRUE(weights["residual_ratio"].is_null());
  CHECK_TRUE(believed["degrees_of_freedom"]["e"].is_null());
  CHECK_TRUE(weights["degrees_of_freedom"]["e"].is_number());
}

TEST(ChoiceCommands, NoiseFromResidualsIsForTheBestEstimatorAlone) {
  check_refused(run({"reduce", kFrame, "--noise", "residuals", "--estimator", "two-point"}, false),
                "reduce: --noise is for the best estimator, without --tolerance and --deadline-us");
  check_refused(run({"reduce", kFrame, "--noise", "residuals", "--tolerance", "1%"}),
                "reduce: --noise is for the best estimator, without --tolerance and --deadline-us");
}

TEST(ChoiceCommands, ReduceShowsTheRatioOfResidualsToStatedNoise) {
  STRCMP_CONTAINS("residuals over stated noise: ", run({"reduce", kFrame}, false).out.c_str());
}
