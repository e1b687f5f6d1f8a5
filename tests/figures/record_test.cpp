#include "tests/figures/record.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::figures;

namespace {

const Json kRecord = Json::parse(R"json({
  "groups": {"all": ["stop"]},
  "figures": {"stop": {"what": "e-stop", "command": "stop --press", "text": "median {median} µs, largest {max} µs",
    "measured": "2026-11-22", "machine": "m",
    "values": {"median": {"value": 43, "tolerance": 0.1, "worse": "higher", "pattern": "median ([0-9.]+)"},
               "max": {"value": 217.5, "tolerance": 0.1, "pattern": "max ([0-9.]+)", "take": "max"}}}}})json");

const Json& value(const char* name) { return kRecord["figures"]["stop"]["values"][name]; }

}  // namespace

TEST_GROUP(FiguresRecord){};

TEST(FiguresRecord, ATableIsGeneratedBetweenItsMarkers) {
  const auto text = regenerated("a\n<!-- figures: all -->\nold\n<!-- end of figures -->\nb", kRecord);
  STRCMP_EQUAL(
      "a\n<!-- figures: all -->\n| what | measured | when | command |\n|---|---|---|---|\n"
      "| e-stop | median 43 µs, largest 217.5 µs | 2026-11-22 | `stop --press` |\n\nOn: m.\n<!-- end of "
      "figures -->\nb",
      text->c_str());
  STRCMP_EQUAL(text->c_str(), regenerated(*text, kRecord)->c_str());
}

TEST(FiguresRecord, AFigureIsStatedWithinASentence) {
  const auto text = regenerated("<!-- figure: stop -->old<!-- end of figure -->.", kRecord);
  STRCMP_EQUAL("<!-- figure: stop -->median 43 µs, largest 217.5 µs<!-- end of figure -->.", text->c_str());
}

TEST(FiguresRecord, UnknownNamesAndMarkersWithoutAnEndAreRefused) {
  CHECK_FALSE(regenerated("<!-- figures: none --><!-- end of figures -->", kRecord).has_value());
  CHECK_FALSE(regenerated("<!-- figure: none --><!-- end of figure -->", kRecord).has_value());
  CHECK_FALSE(regenerated("<!-- figures: all -->", kRecord).has_value());
}

TEST(FiguresRecord, ValuesAreFoundInAnOutput) {
  const std::string output = "max 3\nmedian 51.26\nmax 200\nmax 7\n";
  DOUBLES_EQUAL(51.3, *found_in(output, value("median")), 0);  // three digits
  DOUBLES_EQUAL(200, *found_in(output, value("max")), 0);
  CHECK_FALSE(found_in("nothing", value("median")).has_value());
}

TEST(FiguresRecord, AChangeBeyondTheToleranceIsBetterOrWorse) {
  CHECK_EQUAL(Change::same, compare(43, 47, value("median")));
  CHECK_EQUAL(Change::worse, compare(43, 48, value("median")));
  CHECK_EQUAL(Change::moved, compare(43, 38, value("median")));
  CHECK_EQUAL(Change::worse, compare(217.5, 100, value("max")));  // either direction
}
