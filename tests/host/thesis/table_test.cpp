#include <nlohmann/json.hpp>
#include <string>

#include "host/thesis/table.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::thesis;

namespace {

Reason reason_of(double printed, double computed, const Tolerance& tolerance = {}) {
  return compared({printed, 0.01, {}}, computed, tolerance).reason;
}

void check_reason(Reason expected, Reason actual) {
  CHECK_EQUAL(std::string(name(expected)), std::string(name(actual)));
}

Table example() {
  Table table{.id = "5", .title = "Speeds", .columns = {{"v_mps", "v", "m/s", 2}, {"e", "e", "", 2}}};
  Cell misprint = compared({11.73, 0.01, 0.34}, 11.866);
  misprint.reason = Reason::misprint;
  misprint.remark = "below its components";
  table.rows = {{"zero_17", {misprint, compared({0.88, 0.01, 0.05}, 0.8773)}},
                {"zero_23", {as_measured({10.55, 0.01, {}}), computed_only(1.0 / 3.0, 0.125)}}};
  table.notes = {"a note"};
  return table;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_GROUP(ThesisTable){};

TEST(ThesisTable, ValuesThatRoundToThePrintedOneAgree) {
  check_reason(Reason::agrees, reason_of(5.76, 5.7649));
  check_reason(Reason::agrees, reason_of(5.76, 5.755));  // half a digit, which is not exact in binary
  check_reason(Reason::unexplained, reason_of(5.76, 5.7656));
}

TEST(ThesisTable, RoundingExplainsBeforeTheSecondOrderDoes) {
  const Tolerance tolerance{0.01, 0.1};
  check_reason(Reason::rounding, reason_of(1.0, 1.0149, tolerance));
  check_reason(Reason::mean_of_function, reason_of(1.0, 1.0151, tolerance));
  check_reason(Reason::mean_of_function, reason_of(1.0, 0.8851, tolerance));
  check_reason(Reason::unexplained, reason_of(1.0, 1.1151, tolerance));
}

TEST(ThesisTable, OnlyLargerThanRoundingCountsAsADifference) {
  CHECK_FALSE(compared({1.0, 0.01, {}}, 1.012, {0.01, 0.0}).differs());
  CHECK(compared({1.0, 0.01, {}}, 1.2, {0.01, 1.0}).differs());
  CHECK_FALSE(as_measured({1.0, 0.01, {}}).differs());
  CHECK_FALSE(computed_only(1.0).differs());
  DOUBLES_EQUAL(-0.2, *compared({1.0, 0.01, {}}, 1.2).difference(), 1e-15);
}

TEST(ThesisTable, TextShowsBothValuesMarksTheDifferenceAndTellsItsReason) {
  const std::string text = strobe::thesis::text(example());
  CHECK(contains(text, "Table 5. Speeds\n"));
  CHECK(contains(text, "zero_17  printed  11.73 ± 0.34"));
  CHECK(contains(text, "11.87*"));
  CHECK(contains(text,
                 "differences, misprint:\n    zero_17 v: 11.73 printed, 11.866 anew, -0.136 = -13.6 last "
                 "digits, -0.40 sd; below its components\n"));
  CHECK(contains(text, "0.33 ± 0.12"));
  CHECK(contains(text, "  a note\n"));
  CHECK_FALSE(contains(text, " \n"));
}

TEST(ThesisTable, JsonHasEveryNumberToItsLastBit) {
  const std::string line = json(example());
  CHECK_EQUAL(std::string::npos, line.find('\n'));
  const auto parsed = nlohmann::json::parse(line);
  CHECK_EQUAL("5", parsed["table"].get<std::string>());
  const auto& first = parsed["rows"][0];
  CHECK_EQUAL("zero_17", first["label"].get<std::string>());
  DOUBLES_EQUAL(11.73, first["v_mps"]["printed"].get<double>(), 0.0);
  DOUBLES_EQUAL(11.73 - 11.866, first["v_mps"]["difference"].get<double>(), 0.0);
  CHECK_EQUAL("misprint", first["v_mps"]["reason"].get<std::string>());
  DOUBLES_EQUAL(1.0 / 3.0, parsed["rows"][1]["e"]["computed"].get<double>(), 0.0);
  CHECK_FALSE(parsed["rows"][1]["e"].contains("printed"));
}

TEST(ThesisTable, JsonLeavesOutWhatIsNotANumber) {
  Table table{.id = "x", .title = "", .columns = {{"a", "a", "", 1}}};
  table.rows = {{"r", {computed_only(std::nan(""))}}};
  CHECK_FALSE(nlohmann::json::parse(json(table))["rows"][0]["a"].contains("computed"));
}
