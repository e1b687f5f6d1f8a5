// What laboratories report: read, gathered by quantity, told.
#include <nlohmann/json.hpp>

#include <string>

#include "host/interlaboratory/comparison.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::interlaboratory;
using nlohmann::json;

constexpr const char* kNorth =
    R"({"laboratory":"north","results":[{"name":"e","value":0.850,"expanded_uncertainty":0.006},)"
    R"({"name":"height","value":1.38,"expanded_uncertainty":0.02,"standard_uncertainty":0.008,"unit":"m"},)"
    R"({"name":"mass","value":57.1}]})";
constexpr const char* kSouth =
    R"({"series":"today","quantities":{"e":{"n":7,"mean":0.858,"total_sd":0.003,"expanded_uncertainty":0.008},)"
    R"("v_td_mps":{"mean":30.1,"total_sd":0.05,"expanded_uncertainty":0.1},"mu":{"mean":0.5,"expanded_uncertainty":null}}})";

LaboratoryReport report(const char* text, const std::string& name = "") {
  const auto read = read_report(text, "file.json", name);
  CHECK_TEXT(read.has_value(), read ? "" : read.error().message.c_str());
  return *read;
}

std::string problem(const std::string& text) {
  const auto read = read_report(text, "file.json", "");
  CHECK_FALSE(read.has_value());
  return read.error().message;
}

}  // namespace

TEST_GROUP(LaboratoryComparison){};

TEST(LaboratoryComparison, ReadsResultsAndSeriesAlike) {
  const LaboratoryReport north = report(kNorth), south = report(kSouth);
  CHECK_EQUAL(std::string("north"), north.laboratory);
  CHECK_EQUAL(std::string("file"), south.laboratory);
  CHECK_EQUAL(std::string("given"), report(kNorth, "given").laboratory);
  LONGS_EQUAL(2, north.values.size());  // the mass has no uncertainty
  DOUBLES_EQUAL(0.003, north.values[0].standard_uncertainty, 1e-15);
  DOUBLES_EQUAL(0.008, north.values[1].standard_uncertainty, 0.0);
  LONGS_EQUAL(2, south.values.size());
  CHECK_EQUAL(std::string("m/s"), south.values[1].unit);
}

TEST(LaboratoryComparison, TellsSeveralSeriesOfAFileApart) {
  const std::string one = kSouth, two = one + "\n" + std::string(kSouth).replace(11, 5, "other");
  CHECK_EQUAL(std::string("today: e"), report(two.c_str()).values[0].quantity);
  CHECK_EQUAL(std::string("other: e"), report(two.c_str()).values[2].quantity);
}

TEST(LaboratoryComparison, ReadsVerdictsAboveTheLevelOfShots) {
  const LaboratoryReport verdict = report(
      R"({"protocol":"itf-court-pace","values":[)"
      R"({"name":"cpr","of":{"position":"1","ball":"2","shot":"7"},"value":31,"sd":1,"expanded_uncertainty":2},)"
      R"({"name":"rebound","of":{"position":"1","ball":"2","shot":null},"value":140,"sd":1,"expanded_uncertainty":2.1},)"
      R"({"name":"rating","of":{"position":null,"ball":null,"shot":null},"value":34,"sd":0.4,"expanded_uncertainty":0.9}]})");
  LONGS_EQUAL(2, verdict.values.size());
  CHECK_EQUAL(std::string("rebound, position 1, ball 2"), verdict.values[0].quantity);
  CHECK_EQUAL(std::string("rating"), verdict.values[1].quantity);
  DOUBLES_EQUAL(0.4, verdict.values[1].standard_uncertainty, 0.0);
}

TEST(LaboratoryComparison, RefusesWhatIsNoReport) {
  STRCMP_CONTAINS("file.json:2: no JSON object", problem("{}\nnonsense\n").c_str());
  STRCMP_CONTAINS("no result with an expanded uncertainty", problem("{}").c_str());
  STRCMP_CONTAINS("an entry without a name", problem(R"({"results":[{"value":1}]})").c_str());
  STRCMP_CONTAINS("no result", problem(R"({"results":[{"name":"e","value":1,"expanded_uncertainty":-1}]})").c_str());
}

TEST(LaboratoryComparison, IsOfWhatTheyHaveInCommon) {
  const auto comparison = compare({report(kNorth), report(kSouth, "south")}, {});
  LONGS_EQUAL(1, comparison->quantities.size());
  LONGS_EQUAL(2, comparison->remarks.size());
  CHECK_EQUAL(std::string("height: not compared: one laboratory alone reports it"), comparison->remarks[0]);
  const json told = json::parse(comparison_json(comparison->quantities[0]));
  DOUBLES_EQUAL(0.8, told["results"][1]["en"]["value"].get<double>(), 1e-9);  // 0.008 / sqrt(0.006^2 + 0.008^2)
  CHECK_EQUAL(std::string("satisfactory"), told["results"][1]["en"]["performance"].get<std::string>());
  CHECK(told["results"][0]["en"].is_null());
  CHECK_EQUAL(std::string("north"), told["assigned"]["reference"].get<std::string>());
  CHECK(all_agree(*comparison));
  const auto lines = comparison_text(*comparison);
  STRCMP_CONTAINS("e: assigned 0.8500 ± 0.0060 (north)", lines[0].c_str());
  STRCMP_CONTAINS("reference", lines[2].c_str());
  STRCMP_CONTAINS("+0.80", lines[3].c_str());
}

TEST(LaboratoryComparison, RefusesNamesThatNobodyOrTwoHave) {
  const auto said = [](const ComparisonTerms& terms, const char* second = "south") {
    const auto compared = compare({report(kNorth), report(kSouth, second)}, terms);
    return compared ? std::string("compared") : compared.error().message;
  };
  STRCMP_CONTAINS("two laboratories are called \"north\"", said({}, "north").c_str());
  STRCMP_CONTAINS("no laboratory \"west\" among north, south", said({"west", {}, {}}).c_str());
  STRCMP_CONTAINS("no laboratory reports \"omega\"; there are e, height", said({"", {}, {"omega"}}).c_str());
  STRCMP_CONTAINS("no quantity in common", said({"", {}, {"height"}}).c_str());
  const char* in_cm = R"({"results":[{"name":"height","value":138,"expanded_uncertainty":2,"unit":"cm"}]})";
  STRCMP_CONTAINS("reports it in \"cm\", others in \"m\"",
                  compare({report(kNorth), report(in_cm, "west")}, {}).error().message.c_str());
}

TEST(LaboratoryComparison, DrawsEachLaboratoryAtItsPlace) {
  const auto comparison = compare({report(kNorth), report(kSouth, "south")}, {});
  const auto figure = comparison_figure(*comparison);
  LONGS_EQUAL(1, figure.panels.size());
  const auto& points = figure.panels[0].series[1].points;
  DOUBLES_EQUAL(2.0, points[1].x, 0.0);
  DOUBLES_EQUAL(0.850, points[1].low, 1e-12);
  DOUBLES_EQUAL(0.866, points[1].high, 1e-12);
}
