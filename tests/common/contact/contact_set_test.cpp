#include <string>

#include "common/data/contact_set.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using strobe::data::is_end_point;
using strobe::data::parse_contact_csv;

namespace {

const std::string kHeader = "time_fraction,x_fraction,y_fraction,rotation_fraction\n";

std::string complaint(const std::string& text) {
  return strobe::testing::error_of(parse_contact_csv(text, "a.csv"));
}

void check_complaint(const std::string& expected, const std::string& text) {
  CHECK_EQUAL(expected, complaint(text));
}

}  // namespace

TEST_GROUP(ContactSet){};

TEST(ContactSet, ReadsRowsInTheirOrder) {
  const auto set = parse_contact_csv(kHeader + "0,0,0,0\n0.5, 0.6 ,-2e-1,-3.25\n", "a.csv");
  CHECK(set.has_value());
  LONGS_EQUAL(2, set->rows.size());
  DOUBLES_EQUAL(0.5, set->rows[1].time_fraction, 0.0);
  DOUBLES_EQUAL(0.6, set->rows[1].x_fraction, 0.0);
  DOUBLES_EQUAL(-0.2, set->rows[1].y_fraction, 0.0);
  DOUBLES_EQUAL(-3.25, *set->rows[1].rotation_fraction, 0.0);
}

TEST(ContactSet, ReadsFilesFromOtherSystems) {
  const auto set = parse_contact_csv(
      "\xEF\xBB\xBFtime_fraction,x_fraction,y_fraction,rotation_fraction\r\n\r\n0.5,0.6,-0.2,0.1", "a.csv");
  CHECK(set.has_value());
  LONGS_EQUAL(1, set->rows.size());
}

TEST(ContactSet, NamesTheLineAndColumnOfWhatIsNotANumber) {
  check_complaint("a.csv:2: y_fraction: 'x' is not a number", kHeader + "0.5,0.6,x,0.1\n");
  check_complaint("a.csv:3: time_fraction: 'nan' is not a number", kHeader + "0,0,0,0\nnan,0.6,0,0.1\n");
  check_complaint("a.csv:2: x_fraction: '-inf' is not a number", kHeader + "0.5,-inf,0,0.1\n");
  check_complaint("a.csv:2: x_fraction: '0.5m' is not a number", kHeader + "0.5,0.5m,0,0.1\n");
  check_complaint("a.csv:2: x_fraction: '0x1p-1' is not a number", kHeader + "0.5,0x1p-1,0,0.1\n");
  check_complaint("a.csv:2: x_fraction: '1e999' is too large or too small a number",
                  kHeader + "0.5,1e999,0,0.1\n");
  check_complaint("a.csv:2: rotation_fraction: is missing", kHeader + "0.5,0.5,0,\n");
}

TEST(ContactSet, CountsBlankLinesWhenItNamesALine) {
  check_complaint("a.csv:4: x_fraction: '?' is not a number", kHeader + "\n\n0.5,?,0,0.1\n");
}

TEST(ContactSet, RefusesRowsOfAnotherLength) {
  check_complaint("a.csv:2: rotation_fraction: has 3 columns instead of 4", kHeader + "0.5,0.6,0.1\n");
  check_complaint("a.csv:2: has 5 columns instead of 4", kHeader + "0.5,0.6,0.1,0.2,0.3\n");
}

TEST(ContactSet, RequiresItsHeader) {
  const std::string wanted = "the header must be time_fraction,x_fraction,y_fraction,rotation_fraction";
  check_complaint("a.csv:1: " + wanted, "0.5,0.6,0.1,0.2\n");
  check_complaint("a.csv:1: " + wanted, "time_fraction,y_fraction,x_fraction,rotation_fraction\n0,0,0,0\n");
  check_complaint("a.csv:1: is empty; " + wanted, "\n \n");
}

TEST(ContactSet, RefusesAFileWithoutRows) {
  check_complaint("a.csv:1: has no rows below the header", kHeader);
}

TEST(ContactSet, TellsMillisecondsFromFractions) {
  const std::string range = "time_fraction: must be from -0.05 to 1.05: 0 is touchdown, 1 lift-off";
  check_complaint("a.csv:2: " + range, kHeader + "2.6,0.5,-0.2,0.1\n");
  check_complaint("a.csv:4: " + range, kHeader + "0,0,0,0\n1.05,0.5,-0.2,0.1\n1.0500001,0.5,-0.2,0.1\n");
  check_complaint("a.csv:3: " + range, kHeader + "-0.05,0.5,-0.2,0.1\n-0.06,0.5,-0.2,0.1\n");
}

TEST(ContactSet, CountsEqualRowsOnce) {
  const std::string row = "0.1,0.1,-0.3,0.1\n";
  const auto set = parse_contact_csv(kHeader + row + "0.10,0.1,-3e-1,.1\n" + "0.2,0.1,-0.3,0.1\n" + row, "a.csv");
  LONGS_EQUAL(2, set->rows.size());
  DOUBLES_EQUAL(0.2, set->rows[1].time_fraction, 0.0);
  LONGS_EQUAL(2, set->repeated);
}

TEST(ContactSet, KnowsTheTwoRowsThatHoldByDefinition) {
  CHECK(is_end_point({0.0, 0.0, 0.0, 0.0}));
  CHECK(is_end_point({1.0, 1.0, 0.0, 1.0}));
  CHECK_FALSE(is_end_point({0.0, 0.0, 0.0, 0.1}));
  CHECK_FALSE(is_end_point({1.0, 1.0, 0.0, std::nullopt}));
}
