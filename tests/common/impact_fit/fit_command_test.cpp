#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::testing;

namespace {

const std::string kHeader =
    "utc,shot_id,rejected,vx_td_mps,vy_td_mps,omega_td_radps,vx_lo_mps,omega_lo_radps,e,sd_vx_td_mps,"
    "sd_vy_td_mps,sd_omega_td_radps,sd_vx_lo_mps,sd_omega_lo_radps,sd_e,flags,spin,angle_deg,remarks\n";

/// Gripping shots with an offset (alpha .55, e_x .1, d 2 mm at full rolling), one with a comma in its
/// remarks, one rejected, one whose spin could not be had, one that may be aliased.
const std::string kShots =
    "t,1,,15.62,-6.71,2.6,8.8,-300,0.86,.05,.05,1,.05,2,.01,,zero,23,\n"
    "t,2,,14.49,-9.95,-1.1,8.1,-283,0.77,.05,.05,1,.05,2,.01,,zero,34,\"wet, slow\"\n"
    "t,3,late,14.49,-9.95,-1.1,1.0,0,0.77,.05,.05,1,.05,2,.01,,zero,34,\n"
    "t,4,,14.49,-9.95,,8.1,-283,0.77,.05,.05,,.05,2,.01,too_few_images,zero,34,\n"
    "t,5,,13.46,-11.74,23.5,7.1,-250,0.75,.05,.05,1,.05,2,.01,,zero,41,\n"
    "t,6,,13.46,-11.74,23.5,7.1,250,0.75,.05,.05,1,.05,2,.01,late_flash;spin_aliased,zero,41,\n"
    "t,7,,11.70,-13.25,5.6,6.2,-215,0.71,.05,.05,1,.05,2,.01,,zero,49,\n";

CompletedProcess run_fit(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {STROBE_PROGRAM, "fit"});
  return run_program(std::move(arguments));
}

}  // namespace

TEST_GROUP(FitCommand) {
  TemporaryFolder folder;

  std::string file(const std::string& text) {
    write_text(folder / "results.csv", text);
    return folder / "results.csv";
  }
};

TEST(FitCommand, FitsTheThesissConditionsByDefault) {
  const auto lines = jsons_of(run_fit({"--json"}));
  LONGS_EQUAL(22, lines.size());
  CHECK_EQUAL("fit", lines[0]["type"]);
  const auto& mu = lines[0]["parameters"]["mu"];
  DOUBLES_EQUAL(0.570, mu["value"].get<double>(), 0.001);
  CHECK(mu["sd"].get<double>() > 0.0);
  CHECK_EQUAL("fitted", mu["status"]);
  DOUBLES_EQUAL(3.0, lines[0]["parameters"]["d_mm"]["value"].get<double>(), 0.05);
  CHECK(lines[0]["correlation"].contains("d,u0"));
  CHECK_EQUAL("zero_17", lines[1]["name"]);
  CHECK_EQUAL("slides", lines[1]["regime"]);
  CHECK(lines[1]["z_vx"].is_number());
}

TEST(FitCommand, LeavesSpinsOutInTurn) {
  const auto lines = jsons_of(run_fit({"--json", "--leave-out", "spin"}));
  LONGS_EQUAL(22 + 3 + 1, lines.size());
  CHECK_EQUAL("left_out", lines[22]["type"]);
  CHECK_EQUAL("top", lines[23]["group"]);
  CHECK_EQUAL("validation", lines[25]["type"]);
  CHECK_EQUAL(21, lines[25]["count"]);
}

TEST(FitCommand, LeavesAShotOutWhoseNumbersNoImpactCanHaveAndNamesIt) {
  const std::string bad = "t,8,,11.70,-13.25,5.6,6.2,-215,1.004,.05,.05,1,.05,2,.01,,zero,49,\n";
  const std::string path = file(kHeader + kShots + bad);
  const auto lines = jsons_of(run_fit({path, "--json", "--free", "ex,d"}));
  LONGS_EQUAL(1 + 4, lines.size());
  CHECK_EQUAL(path + ": shot 8: e must be from 0 to 1",
              lines[0]["inputs"]["impossible"][0].get<std::string>());
  STRCMP_CONTAINS(("left out: " + path + ": shot 8: e must be from 0 to 1\n").c_str(),
                  run_fit({path, "--free", "ex,d"}).out.c_str());
  file(kHeader + bad);
  const CompletedProcess nothing = run_fit({path});
  CHECK_EQUAL(ExitStatus({2, 0}), *nothing.status);
  STRCMP_CONTAINS(": shot 8: e must be from 0 to 1, and no other shot is left", nothing.err.c_str());
}

TEST(FitCommand, FitsShotsOfASessionAndSaysWhatItLeftOut) {
  const std::string path = file(kHeader + kShots);
  const CompletedProcess run = run_fit({path, "--json", "--free", "ex,d", "--weights", "sd"});
  const auto lines = jsons_of(run);
  CHECK_EQUAL("", run.err);
  LONGS_EQUAL(1 + 4, lines.size());
  CHECK_EQUAL(1, lines[0]["inputs"]["rejected"]);
  CHECK_EQUAL(2, lines[0]["inputs"]["incomplete"]);
  CHECK_EQUAL("fixed", lines[0]["parameters"]["mu"]["status"]);
  CHECK_EQUAL(path + ": shot 2", lines[2]["name"].get<std::string>());
  CHECK_EQUAL("zero_34", lines[2]["series"]);
}

TEST(FitCommand, TextNamesEachParameterWithItsUncertainty) {
  check_prints(run_fit({"--model", "grip", "--free", "mu,ex,alpha"}),
               {"mu     0.580 +- 0.028; 95 %: 0.52", "at upper bound; at least 0.65",
                "21 observations being independent"});
}

TEST(FitCommand, GivesTheIntervalAndSaysFromWhatItWasMade) {
  const auto thesis = jsons_of(run_fit({"--json"}))[0];
  const auto& mu = thesis["parameters"]["mu"];
  CHECK(mu["interval_95"][0].get<double>() < 0.57 && mu["interval_95"][1].get<double>() > 0.57);
  CHECK(mu["degrees_of_freedom"].get<double>() > 0.0);
  CHECK_EQUAL(21, thesis["clusters"]);
  CHECK_EQUAL("equal", thesis["inputs"]["weights"]);
  CHECK_EQUAL("clustered", thesis["inputs"]["covariance"]);
  const std::string path = file(kHeader + kShots);
  CHECK_EQUAL("sd", jsons_of(run_fit({path, "--json", "--free", "ex,d"}))[0]["inputs"]["weights"]);
  const std::string without = "t,8,,11.70,-13.25,5.6,6.3,-215,0.71,,,,,,,,zero,49,\n";
  file(kHeader + kShots + without);
  CHECK_EQUAL("equal", jsons_of(run_fit({path, "--json", "--free", "ex,d"}))[0]["inputs"]["weights"]);
}

TEST(FitCommand, FixedValuesAreKept) {
  const auto lines = jsons_of(run_fit({"--json", "--fix", "d=2.5", "--fix", "u0=1e-9"}));
  DOUBLES_EQUAL(2.5, lines[0]["parameters"]["d_mm"]["value"].get<double>(), 1e-12);
  CHECK_EQUAL("fixed", lines[0]["parameters"]["d_mm"]["status"]);
}

TEST(FitCommand, TakesFixedValuesOneByOneOrInAList) {
  const auto apart = run_fit({"--json", "--fix", "d=2.5", "--fix", "mu=0.5"});
  LONGS_EQUAL(0, apart.status->code);
  CHECK_EQUAL(apart.out, run_fit({"--json", "--fix", "d=2.5,mu=0.5"}).out);
}

TEST(FitCommand, RefusesParametersThatThereAreNot) {
  check_refused(run_fit({"--free", "mu,friction"}),
                "fit: --free, --fix: no parameter \"friction\"; there are mu, ex, d, u0 and alpha");
  check_refused(run_fit({"--model", "slide-roll", "--free", "mu,ex"}),
                "fit: ex: the model does not have this parameter");
  check_refused(run_fit({"--free", "mu", "--fix", "mu=0.5"}), "fit: mu is in both --free and --fix");
  check_refused(run_fit({"--fix", "mu"}), "fit: --fix mu: must be name=value");
  check_refused(run_fit({"--fix", "mu=nan"}), "fit: --fix mu=nan: the value is not a number");
  check_refused(run_fit({"--fix", "d=40"}), "fit: --fix d=40: must be from 0 to 32.55 mm");
}

TEST(FitCommand, NamesFileLineAndColumnOfWhatIsWrong) {
  std::string path = file(kHeader + "t,1,,15.62,-6.71,fast,8.8,-300,0.86,,,,,,,,zero,23,\n");
  check_refused(run_fit({path}), path + ":2: omega_td_radps: 'fast' is not a number");
  path = file(kHeader + "t,1,,15.62,-6.71,1,8.8,-300,0.86,-0.1,,,,,,,zero,23,\n" + kShots);
  check_refused(run_fit({path}),
                "fit: " + path +
                    ": shot 1: standard deviations must be finite and not negative, those of "
                    "lift-off positive where they weight the fit");
  path = file(kHeader + "t,1,,15.62\n");
  check_refused(run_fit({path}), path + ":2: 4 cells where the header has 19");
  path = file("shot_id,vx_td_mps\n1,2\n");
  check_refused(run_fit({path}), path + ":1: vy_td_mps: is missing in the header");
  path = file("");
  check_refused(run_fit({path}), path + ": is empty");
  path = file(kHeader);
  check_refused(run_fit({path}),
                path + ": no shot with vx, vy, omega at touchdown, vx, omega at lift-off and e");
  check_refused(run_fit({folder.path().string()}), folder.path().string() + ": Is a directory");
}

TEST(FitCommand, RefusesMoreParametersThanTheShotsGiveNumbers) {
  const std::string path = file(kHeader + "t,1,,15.62,-6.71,1,8.8,-300,0.86,,,,,,,,zero,23,\n");
  check_refused(run_fit({path}),
                "fit: too few observations for so many parameters: each gives two numbers (vx and omega)");
}

TEST(FitCommand, FailsWhereParametersCannotBeToldApart) {
  std::string rows;
  for (const char* vx : {"6.20", "6.22", "6.18", "6.21"})
    rows += std::string("t,1,,11.70,-13.25,5.6,") + vx + ",-215,0.71,.05,.05,1,.05,2,.01,,zero,49,\n";
  const CompletedProcess run = run_fit({file(kHeader + rows)});
  LONGS_EQUAL(1, run.status->code);
  CHECK(run.err.find("cannot be separated") != std::string::npos);
}

namespace {

/// A shot that slides throughout, mu .3 and alpha 2/3 by the impulse balance; `utc` and `rest` are of no model.
std::string sliding_row(const std::string& utc, const std::string& lift_off, const std::string& sds,
                        const std::string& rest) {
  return utc + ",1,,15.62,-6.71,2.6," + lift_off + ",0.86," + sds + ",," + rest + "\n";
}
const std::string kSds = ".05,.05,1,.05,2,.01", kLiftOff = "11.876,-169.93";

nlohmann::json parameters_of(const CompletedProcess& run) { return jsons_of(run)[0]["parameters"]; }

}  // namespace

TEST(FitCommand, ARowCountsOnceHoweverOftenItStandsThere) {
  const std::string row = sliding_row("t", kLiftOff, kSds, "zero,23,");
  const std::string copies = row + sliding_row("u", kLiftOff, kSds, "zero,23,again") +
                             sliding_row("v", "11.8760,-1.6993e2", kSds, "top,34,") + row + row;
  const std::string count = ": shot 1: 5 with the same numbers, which count as one";
  for (const std::string model : {"slide-roll", "grip"}) {
    const std::vector<std::string> asked{"--model", model,          "--free", "mu",    "--fix",
                                         "alpha=0.6666", "--covariance", "stated", "--json"};
    const auto with = [&](const std::string& path) {
      std::vector<std::string> words = asked;
      words.insert(words.begin(), path);
      return run_fit(words);
    };
    const auto alone = parameters_of(with(file(kHeader + row)));
    CHECK_EQUAL("fitted", alone["mu"]["status"]);
    const std::string path = file(kHeader + copies);
    CHECK_EQUAL(alone, parameters_of(with(path)));
    CHECK_EQUAL(path + count, jsons_of(with(path))[0]["inputs"]["repeated"][0].get<std::string>());
    // With one more row likewise.
    const std::string other = "t,2,,14.49,-9.95,-1.1,9.207,-244.5,0.77,.05,.05,1,.05,2,.01,,zero,34,\n";
    CHECK_EQUAL(parameters_of(with(file(kHeader + row + other))), parameters_of(with(file(kHeader + copies + other))));
  }
  const std::string path = file(kHeader + copies);
  const std::string few = "fit: too few observations for so many parameters: each gives two numbers (vx and omega)";
  for (const std::string model : {"grip", "grip-offset", "ode"})
    check_refused(run_fit({path, "--model", model}), few + " (" + path + count + ")");
  const std::string told = "model slide-roll: 1 observations\n  " + path + count + "\n";
  check_prints(run_fit({path, "--model", "slide-roll"}), {told.c_str()});
}

TEST(FitCommand, OfRowsThatDifferInTheirSdsAloneTheLargestCount) {
  const auto mu = [&](const std::string& rows) {
    const std::string path = file(kHeader + rows);
    return parameters_of(run_fit({path, "--model", "slide-roll", "--json", "--covariance", "stated"}))["mu"];
  };
  const auto row = [](const std::string& sds) { return sliding_row("t", kLiftOff, sds, "zero,23,"); };
  CHECK_EQUAL(mu(row(".05,.05,1,.08,2,.02")), mu(row(".05,.05,.5,.08,1,.02") + row(".03,.04,1,.05,2,.01")));
}

TEST(FitCommand, SaysWhenTheRowsScatterLessThanTheirSds) {
  std::string rows;
  for (int i = 0; i < 5; ++i)
    rows += sliding_row("t", "11.876" + std::to_string(i) + ",-169.93" + std::to_string(i), kSds, "zero,23,");
  check_prints(run_fit({file(kHeader + rows), "--model", "slide-roll"}),
               {"sd and interval from the stated sd: the observations scatter less than these let expect"});
}

TEST(FitCommand, FitsTheContactMechanicsWithItsPosterior) {
  const auto lines = jsons_of(run_fit({"--json", "--model", "ode", "--leave-out", "condition"}));
  LONGS_EQUAL(1 + 21 + 21 + 1, lines.size());
  const auto& fit = lines[0];
  const auto& mu = fit["parameters"]["mu"];
  DOUBLES_EQUAL(0.536, mu["value"].get<double>(), 0.003);
  CHECK(mu["interval_95"][0].get<double>() < 0.53 && mu["interval_95"][1].get<double>() > 0.55);
  CHECK_EQUAL("fixed", fit["parameters"]["dwell_ms"]["status"]);
  const auto& posterior = fit["posterior"];
  CHECK_EQUAL("importance", posterior["method"]);
  CHECK_EQUAL(1, posterior["seed"]);
  CHECK_TRUE(posterior["reliable"].get<bool>());
  CHECK(posterior["pareto_k"].get<double>() < 0.7);
  LONGS_EQUAL(6, posterior["correlation"].size());
  CHECK_EQUAL("mu", posterior["correlation_parameters"][0]);
  DOUBLES_EQUAL(1.0, posterior["correlation"][2][2].get<double>(), 1e-12);
  DOUBLES_EQUAL(0.5, posterior["prior"]["mu"]["median"].get<double>(), 1e-12);
  CHECK_EQUAL("slides", lines[1]["regime"]);
  CHECK_EQUAL(21, lines.back()["count"]);
}

TEST(FitCommand, TheContactMechanicsTakesTheOptionsOfTheOtherModels) {
  const auto one = run_fit({"--model", "ode", "--json", "--seed", "7", "--draws", "500"});
  CHECK_EQUAL(one.out, run_fit({"--model", "ode", "--json", "--seed", "7", "--draws", "500"}).out);
  CHECK_EQUAL(7, jsons_of(one)[0]["posterior"]["seed"]);
  const auto fixed =
      jsons_of(run_fit({"--model", "ode", "--json", "--sampler", "laplace", "--fix",
                        "u0=20,damping_ratio=0.5", "--covariance", "residuals", "--spin", "zero"}));
  LONGS_EQUAL(1 + 7, fixed.size());
  DOUBLES_EQUAL(20.0, fixed[0]["parameters"]["u0_mps"]["value"].get<double>(), 0.0);
  CHECK_EQUAL("laplace", fixed[0]["posterior"]["method"]);
  const std::string path = file(kHeader + kShots);
  const auto shots = jsons_of(run_fit({path, "--model", "ode", "--json", "--free", "mu,stiffness_ratio,dwell",
                                       "--covariance", "stated", "--draws", "500"}));
  LONGS_EQUAL(1 + 4, shots.size());
  CHECK(shots[0]["parameters"]["dwell_ms"]["sd"].get<double>() > 0.0);
  DOUBLES_EQUAL(4.7, shots[0]["posterior"]["prior"]["dwell_ms"]["median"].get<double>(), 1e-12);
}

TEST(FitCommand, TheContactMechanicsTellsWhatTheDataDoNot) {
  check_prints(run_fit({"--model", "ode"}),
               {"stiffness_ratio 1.", "posterior: importance sampling", "(seed 1)",
                "prior, 95 %: mu 0.13 to 2", "not determined: u0 and offset_share apart"});
}

TEST(FitCommand, OptionsOfTheContactMechanicsAreRefusedElsewhere) {
  check_refused(run_fit({"--seed", "3"}), "fit: --seed: only --model ode has it");
  check_refused(run_fit({"--model", "grip", "--gravity-mps2", "0"}),
                "fit: --gravity-mps2: only --model ode has it");
  check_refused(run_fit({"--model", "ode", "--free", "mu,ex"}),
                "fit: ex: the model does not have this parameter");
  check_refused(run_fit({"--model", "ode", "--fix", "dwell=500"}),
                "fit: --fix dwell=500: must be from 0.1 to 100 ms");
}
