// `strobe bounces` as a user runs it.
#include <set>
#include <string>

#include "tests/support/json_lines.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::testing;

namespace {

CompletedProcess bounces(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {STROBE_PROGRAM, "bounces"});
  return run_program(std::move(arguments));
}

}  // namespace

TEST_GROUP(BouncesCommand){};

TEST(BouncesCommand, PrintsEverySetWithItsAgreementAndBalance) {
  const CompletedProcess run = bounces({});
  CHECK_EQUAL("", run.err);
  check_prints(run, {"Predicted before anything is fitted", "cross_2002_table_2\n  R. Cross; ",
                     "\nwood_45                  vx 0.252    1.61 ± 0.06         1.61  -0.0 ",
                     "\nrms; of z                vx ", "\nangular momentum               ex           alpha ",
                     "\none alpha for all                   0.510 ± 0.017   0.53",
                     "\nlindsey_strings\n  C. Lindsey; "});
}

TEST(BouncesCommand, PrintsOneJsonObjectABounce) {
  const CompletedProcess run = bounces({"--json"});
  LONGS_EQUAL(0, run.status->code);
  const auto rows = parse_json_lines(run.out);
  LONGS_EQUAL(66, rows.size());  // 6 + 1 + 1 + 8 + 13 + 14 + 23
  std::set<std::string> sets;
  for (const auto& row : rows) sets.insert(row["set"].get<std::string>());
  LONGS_EQUAL(7, sets.size());
  CHECK_EQUAL("wood_20", rows[0]["row"].get<std::string>());
  DOUBLES_EQUAL(-34.9, rows[0]["measured"]["omega_lo_radps"].get<double>(), 0.0);
  const auto& mechanics = rows[0]["predictions"]["mechanics"];
  DOUBLES_EQUAL(mechanics["omega_lo_radps"].get<double>() + 34.9,
                mechanics["omega_residual_radps"].get<double>(), 1e-12);
  CHECK(rows.back()["measured"]["vx_lo_mps"].is_null());
  CHECK_EQUAL("normal speed outside 2-16 m/s", mechanics["not_valid"].get<std::string>());
  CHECK_EQUAL("wood_45", rows[1]["row"].get<std::string>());
  CHECK_EQUAL("", rows[1]["predictions"]["mechanics"]["not_valid"].get<std::string>());
  CHECK_EQUAL("constants of a tennis ball", rows.back()["predictions"]["grip"]["not_valid"].get<std::string>());
}

TEST(BouncesCommand, PrintsOneSet) {
  LONGS_EQUAL(8, parse_json_lines(bounces({"--set", "cross_2010", "--json"}).out).size());
}

TEST(BouncesCommand, TheReadmesTableIsWhatItSummarizes) {
  const CompletedProcess run = bounces({"--summary"});
  LONGS_EQUAL(0, run.status->code);
  const std::string readme = read_text(std::string(STROBE_BOUNCES_FOLDER) + "/README.md");
  CHECK_TEXT(readme.find("```\n" + run.out + "```\n") != std::string::npos, run.out.c_str());
}

TEST(BouncesCommand, NamesTheSetsThereAre) {
  const CompletedProcess run = bounces({"--set", "brody"});
  LONGS_EQUAL(2, run.status->code);
  CHECK_EQUAL("", run.out);
  CHECK_EQUAL(
      "strobe: bounces: no set brody; there are cross_2002_table_2, cross_2002_table_1, "
      "cross_2002_superball, "
      "cross_2010, cross_2014, lindsey_strings, kharaz_2001\n",
      run.err);
}

TEST(BouncesCommand, ReadsAFolderOfOnesOwnAndSaysWhatIsWrongInIt) {
  const TemporaryFolder folder;
  write_text(folder / "balls.csv",
             "ball,build,diameter_m,mass_kg,alpha,alpha_sd,poisson_ratio,source\nb,shell,.066,.057,.55,.02,,mine\n");
  write_text(folder / "sets.csv", "set,publication,read_from\nmine,none,my notes\n");
  write_text(folder / "friction.csv",
             "set,surface,ground,row,mu,elsewhere_mu,elsewhere_mu_sd,reason\nmine,wood,hard,,.3,,,a guess\n");
  const std::string header =
      "row,ball,surface,incline_deg,vx_td_mps,vx_td_sd_mps,vy_td_mps,vy_td_sd_mps,omega_td_radps,omega_td_sd_"
      "radps,"
      "vx_lo_mps,vx_lo_sd_mps,vy_lo_mps,vy_lo_sd_mps,omega_lo_radps,omega_lo_sd_radps\n";
  write_text(folder / "mine.csv", header + "one,b,wood,,3,.1,-1,.1,0,0,2,.1,.8,.1,-30,1\n");
  const auto rows = parse_json_lines(bounces({"--data", folder.path().string(), "--json"}).out);
  LONGS_EQUAL(1, rows.size());
  DOUBLES_EQUAL(0.3, rows[0]["mu"].get<double>(), 0.0);
  write_text(folder / "mine.csv", header + "one,b,wood,,3,.1,1,.1,0,0,2,.1,.8,.1,-30,1\n");
  const CompletedProcess run = bounces({"--data", folder.path().string()});
  LONGS_EQUAL(2, run.status->code);
  CHECK_EQUAL("strobe: bounces: " + (folder / "mine.csv").string() + ":2: vy_td_mps: must be negative\n",
              run.err);
}

TEST(BouncesCommand, DrawsPredictedAgainstMeasuredSpin) {
  const TemporaryFolder folder;
  LONGS_EQUAL(0, bounces({"--figure", (folder / "out").string()}).status->code);
  for (const char* kind : {"svg", "csv"})
    CHECK_TEXT(!read_text(folder / "out" / (std::string("figure_01.") + kind)).empty(), kind);
}
