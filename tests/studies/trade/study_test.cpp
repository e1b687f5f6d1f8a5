#include "tests/studies/trade/study.hpp"

#include <cmath>

#include "tests/studies/trade/report.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::studies::trade;

namespace {

Row row(const char* method, const char* parameter, double cost_us, double error,
        Source source = Source::numerical) {
  return {.method = method,
          .parameter = parameter,
          .cost_us = cost_us,
          .practical = {error, error},
          .thesis = {0.5 * error, 0.5 * error},
          .source = source};
}

Study study(std::vector<Row> rows) {
  return {.name = "s", .title = "", .what = "", .unit = "of v_td", .rows = std::move(rows)};
}

}  // namespace

TEST_GROUP(Dominated){};

TEST(Dominated, NoneWhereFasterIsLessExact) {
  const auto verdicts =
      dominated(study({row("a", "", 1, 1e-2), row("b", "", 2, 1e-4), row("c", "", 9, 1e-8)}));
  for (const auto& verdict : verdicts) CHECK_FALSE(verdict.has_value());
}

TEST(Dominated, ByTheMethodThatBeatsItMostAndByHowMuch) {
  const auto verdicts =
      dominated(study({row("a", "", 1, 1e-2), row("b", "", 2, 1e-6), row("c", "", 8, 1e-2)}));
  CHECK_TRUE(verdicts[2].has_value());
  LONGS_EQUAL(1, verdicts[2]->by);
  DOUBLES_EQUAL(4.0, verdicts[2]->slower, 1e-12);
  DOUBLES_EQUAL(1e4, verdicts[2]->worse, 1e-6);
}

TEST(Dominated, NeitherOfTwoThatCannotBeToldApart) {
  const auto verdicts = dominated(
      study({row("a", "", 1.00, 1.00e-2, Source::noise), row("b", "", 1.04, 1.01e-2, Source::noise)}));
  CHECK_FALSE(verdicts[0].has_value());
  CHECK_FALSE(verdicts[1].has_value());
}

TEST(Dominated, TheLargerErrorOfBothSetsOfScenesCounts) {
  Row lucky = row("a", "", 1, 1e-3);
  lucky.thesis.worst = 1e-1;
  DOUBLES_EQUAL(1e-1, error_of(lucky), 0.0);
}

TEST_GROUP(BrokenInvariants){};

TEST(BrokenInvariants, NoneInASoundStudy) {
  Study sound = study({row("ode", "tolerance=0.001", 1, 1e-4), row("ode", "tolerance=1e-06", 2, 1e-7)});
  sound.reference = 1e-10;
  CHECK_TRUE(broken_invariants({sound}).empty());
}

TEST(BrokenInvariants, AnErrorThatGrowsAsTheToleranceFalls) {
  const auto broken = broken_invariants(
      {study({row("ode", "tolerance=0.001", 1, 1e-7), row("ode", "tolerance=1e-06", 2, 1e-4)})});
  LONGS_EQUAL(1, broken.size());
  CHECK_TRUE(broken[0].find("tolerance=1e-06") != std::string::npos);
}

TEST(BrokenInvariants, MoreStepsThatErrMore) {
  LONGS_EQUAL(
      1,
      broken_invariants({study({row("rk4", "steps=10", 1, 1e-7), row("rk4", "steps=100", 2, 1e-4)})}).size());
}

TEST(BrokenInvariants, AReferenceThatIsNoBetterThanAMethod) {
  Study blurred = study({row("ode", "tolerance=0.001", 1, 1e-4)});
  blurred.reference = 1e-5;
  LONGS_EQUAL(1, broken_invariants({blurred}).size());
}

TEST(BrokenInvariants, AnErrorThatIsNoNumber) {
  LONGS_EQUAL(1, broken_invariants({study({row("rigid", "", 1, std::nan(""))})}).size());
}

TEST_GROUP(CsvText){};

TEST(CsvText, NamesWhatDominatesAndKeepsCommasOutOfFields) {
  Study s = study({row("a", "x=1", 1, 1e-4), row("b", "", 2, 1e-2)});
  s.unit = "of x, y";
  CHECK_EQUAL(
      "study,method,parameter,cost_us,rms,worst,thesis_rms,thesis_worst,error_unit,source,verdict,remark\n"
      "s,a,x=1,1,0.0001,0.0001,5e-05,5e-05,of x; y,numerical,frontier,\n"
      "s,b,,2,0.01,0.01,0.005,0.005,of x; y,numerical,dominated by a x=1: 2.0 times slower and 100 times "
      "less exact,\n",
      csv_text({s}));
}

TEST_GROUP(BeyondOwn){};

TEST(BeyondOwn, AnEngineThatIsFasterThanAllThatAreAsExact) {
  Study s = study(
      {row("rigid", "", 1, 1e-6), row("engine", "step_s=1", 0.5, 1e-6), row("engine", "step_s=2", 2, 1e-5)});
  s.rows[1].general = s.rows[2].general = true;
  const auto beyond = beyond_own(s);
  LONGS_EQUAL(1, beyond.size());
  LONGS_EQUAL(1, beyond[0]);
  LONGS_EQUAL(2, beyond_own(s, "rigid").size());
}
