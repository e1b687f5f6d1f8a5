#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "common/frontier/frontier.hpp"

#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::frontier;

namespace {

const std::string kHeader = "study,method,parameter,cost_us,error,error_unit,note\n";

void check_refused(const std::string& lines, const char* expected) {
  const auto rows = parse_frontier(kHeader + lines, "f.csv");
  CHECK_TEXT(!rows, lines.c_str());
  CHECK_EQUAL(expected, rows.error().message);
}

void check_ranges_refused(const std::string& lines, const char* expected) {
  const auto ranges = parse_ranges("study,quantity,lowest,highest\n" + lines, "r.csv");
  CHECK_TEXT(!ranges, lines.c_str());
  CHECK_EQUAL(expected, ranges.error().message);
}

}  // namespace

TEST_GROUP(FrontierCsv){};

TEST(FrontierCsv, HoldsOneMethodALineInTheirOrder) {
  const auto rows = parse_frontier(
      kHeader +
          "lift_off,grip,,0.02,0.08,of v_td,frontier\nlift_off,ode,tolerance=1e-09,20.5,1e-9,of v_td,\n",
      "f.csv");
  CHECK(rows.has_value());
  LONGS_EQUAL(2, rows->size());
  const Row expected{.study = "lift_off",
                     .method = "ode",
                     .parameter = "tolerance=1e-09",
                     .cost_us = 20.5,
                     .error = 1e-9,
                     .error_unit = "of v_td",
                     .note = ""};
  CHECK_EQUAL(expected, (*rows)[1]);
  CHECK_EQUAL("grip", label((*rows)[0]));
  CHECK_EQUAL("ode tolerance=1e-09", label((*rows)[1]));
}

TEST(FrontierCsv, RefusesWhatIsWrongNamingFileLineAndColumn) {
  check_refused("lift_off,grip,,fast,0.08,of v_td,\n", "f.csv:2: cost_us: 'fast' is not a number");
  check_refused("lift_off,grip,,0,0.08,of v_td,\n", "f.csv:2: cost_us: must be above 0");
  check_refused("lift_off,grip,,1,-0.08,of v_td,\n", "f.csv:2: error: must be at least 0");
  check_refused("lift_off,grip,,1,nan,of v_td,\n", "f.csv:2: error: 'nan' is not a number");
  check_refused("lift_off,,,1,0.1,of v_td,\n", "f.csv:2: method: is missing");
  check_refused("lift_off,grip,,1,0.1,,\n", "f.csv:2: error_unit: is missing");
  check_refused("lift_off,gr\x01ip,,1,0.1,of v_td,\n",
                "f.csv:2: method: has characters that are not printable");
  check_refused("lift_off,grip,,1,0.1,of v_td\n", "f.csv:2: note: has 6 columns instead of 7");
}

TEST(FrontierCsv, RefusesAMethodTwiceAndASecondUnit) {
  check_refused("a,ode,tolerance=1,1,1,x,\na,ode,tolerance=2,1,1,x,\na,ode,tolerance=1,2,1,x,\n",
                "f.csv:4: method: ode tolerance=1 is there twice");
  check_refused("a,ode,,1,1,x,\na,grip,,1,1,y,\n", "f.csv:3: error_unit: differs from x in the same study");
  CHECK(parse_frontier(kHeader + "a,ode,,1,1,x,\nb,ode,,1,1,y,\n", "f.csv").has_value());
}

TEST(FrontierCsv, RefusesAnotherTable) {
  const auto rows = parse_frontier("vx,vy\n1,2\n", "f.csv");
  CHECK_EQUAL("f.csv:1: the header must be study,method,parameter,cost_us,error,error_unit,note",
              rows.error().message);
  CHECK(parse_frontier("", "f.csv").error().message.starts_with("f.csv:1: is empty"));
}

TEST(FrontierCsv, RangesHoldTheirEnds) {
  const auto ranges = parse_ranges("study,quantity,lowest,highest\nlift_off,vx_mps,0,40\n", "r.csv");
  CHECK(ranges.has_value());
  const Quantity at_end[]{{"vx_mps", 40.0}, {"unheard_of", 1e9}};
  LONGS_EQUAL(0, outside(*ranges, "lift_off", at_end).size());
  const Quantity beyond[]{{"vx_mps", 40.5}};
  LONGS_EQUAL(1, outside(*ranges, "lift_off", beyond).size());
  LONGS_EQUAL(0, outside(*ranges, "reduce", beyond).size());
  check_ranges_refused("lift_off,vx_mps,2,1\n", "r.csv:2: highest: is below lowest");
  check_ranges_refused("a,b,0,1\na,b,0,2\n", "r.csv:3: quantity: b is there twice");
  check_ranges_refused("a,b,0\n", "r.csv:2: highest: has 3 columns instead of 4");
}

TEST(FrontierCsv, AParametersValuesAreFoundByName) {
  CHECK(parameter_value("effects=auto;covariance=yes", "covariance") == "yes");
  CHECK(parameter_value("effects=auto;covariance=yes", "effects") == "auto");
  CHECK(!parameter_value("effects=auto", "effect"));
  CHECK(!parameter_value("effects", "effects"));
  CHECK(!parameter_value("", "effects"));
  CHECK_EQUAL("", parameter_value("effects=", "effects"));
}

TEST(FrontierCsv, TheShippedFilesAreOnes) {
  const std::filesystem::path folder = STROBE_SOURCE_DIR "/common/data/frontier";
  const auto rows = parse_frontier(strobe::testing::read_text(folder / "frontier.csv"), "frontier.csv");
  CHECK_TEXT(rows.has_value(), rows ? "" : rows.error().message.c_str());
  if (!std::filesystem::exists(folder / "ranges.csv")) return;
  const auto ranges = parse_ranges(strobe::testing::read_text(folder / "ranges.csv"), "ranges.csv");
  CHECK_TEXT(ranges.has_value(), ranges ? "" : ranges.error().message.c_str());
}
