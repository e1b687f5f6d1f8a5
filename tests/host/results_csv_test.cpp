// results.csv over several runs, and after a killed one.
#include "host/session/results_csv.hpp"

#include <algorithm>
#include <string>

#include "host/session/csv_file.hpp"
#include "tests/support/temporary_folder.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using host::CsvFile;
using host::Outcome;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

/// Fields of one CSV line (RFC 4180 quoting).
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> result{""};
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      result.back() += line[i++];
    } else if (line[i] == '"') {
      quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      result.emplace_back();
    } else {
      result.back() += line[i];
    }
  }
  return result;
}

std::string field(const Outcome& outcome, const std::string& column) {
  const auto names = fields(host::results_header());
  const auto values = fields(host::results_line(outcome, "2026-01-31T09:30:00.000Z"));
  LONGS_EQUAL(names.size(), values.size());
  const auto at = std::find(names.begin(), names.end(), column);
  CHECK_TRUE_TEXT(at != names.end(), column.c_str());
  return values[static_cast<std::size_t>(at - names.begin())];
}

Outcome example() {
  Outcome outcome;
  outcome.boot_id = 0x2a;
  outcome.shot_id = 3;
  outcome.readout.value[reduction::Quantity::e] = 0.1;
  outcome.readout.sd[reduction::Quantity::e] = 0.002;
  outcome.readout.method = "best";
  outcome.readout.flags.set(reduction::Flag::late_flash);
  outcome.readout.flags.set(reduction::Flag::sensor_missing);
  outcome.readout.record = {{"remarks", "wet, \"fast\""}, {"angle_deg", "23"}, {"string_tension", "25"}};
  outcome.readout.flashes = reduction::ShownFlashes{25, 37, 0.001, true};
  outcome.spoilt = "late";
  return outcome;
}

}  // namespace

TEST_GROUP(ResultsTable){};

TEST(ResultsTable, ALineHasAFieldForEachColumn) {
  const Outcome outcome = example();
  STRCMP_EQUAL("2a", field(outcome, "boot_id").c_str());
  STRCMP_EQUAL("3", field(outcome, "shot_id").c_str());
  STRCMP_EQUAL("late", field(outcome, "spoilt").c_str());
  STRCMP_EQUAL("0.1", field(outcome, "e").c_str());
  STRCMP_EQUAL("0.002", field(outcome, "sd_e").c_str());
  STRCMP_EQUAL("", field(outcome, "sd_systematic_e").c_str());
  STRCMP_EQUAL("", field(outcome, "mu").c_str());
  STRCMP_EQUAL("late_flash;sensor_missing", field(outcome, "flags").c_str());
  STRCMP_EQUAL("wet, \"fast\"", field(outcome, "remarks").c_str());
  STRCMP_EQUAL("23", field(outcome, "angle_deg").c_str());
  STRCMP_EQUAL("string_tension=25", field(outcome, "other_notes").c_str());
  STRCMP_EQUAL("25", field(outcome, "first_flash").c_str());
  STRCMP_EQUAL("37", field(outcome, "last_flash").c_str());
  STRCMP_EQUAL("0.001", field(outcome, "index_doubt").c_str());
  STRCMP_EQUAL("", field(Outcome{}, "index_doubt").c_str());
}

TEST(ResultsTable, ASecondRunAppendsWithoutASecondHeader) {
  TemporaryFolder folder;
  for (const char* line : {"one", "two"}) {
    auto csv = CsvFile::open(folder / "results.csv", host::results_header());
    CHECK_TRUE(csv.has_value());
    CHECK_TRUE(csv->append(line).has_value());
  }
  STRCMP_EQUAL((host::results_header() + "\none\ntwo\n").c_str(), read_text(folder / "results.csv").c_str());
}

TEST(ResultsTable, ALineThatAKilledRunLeftOpenIsClosedFirst) {
  TemporaryFolder folder;
  write_text(folder / "results.csv", host::results_header() + "\nhalf a li");
  auto csv = CsvFile::open(folder / "results.csv", host::results_header());
  CHECK_TRUE(csv->append("whole").has_value());
  STRCMP_EQUAL((host::results_header() + "\nhalf a li\nwhole\n").c_str(),
               read_text(folder / "results.csv").c_str());
}

TEST(ResultsTable, ATableOfAnEarlierVersionGoesOnWithItsColumns) {
  TemporaryFolder folder;
  const std::string earlier = host::earlier_results_header();
  write_text(folder / "results.csv", earlier + "\n");
  auto csv = CsvFile::open(folder / "results.csv", host::results_header(), earlier);
  CHECK_TRUE(csv.has_value());
  const std::string line = host::results_line(example(), "2026-01-31T09:30:00.000Z");
  CHECK_TRUE(csv->append(line).has_value());
  const std::string without_flashes = line.substr(0, line.size() - std::string(",25,37,0.001").size());
  STRCMP_EQUAL((earlier + "\n" + without_flashes + "\n").c_str(), read_text(folder / "results.csv").c_str());
  LONGS_EQUAL(fields(earlier).size(), fields(without_flashes).size());
}

TEST(ResultsTable, AnotherVersionsColumnsAreNotMixed) {
  TemporaryFolder folder;
  write_text(folder / "results.csv", "a,b,c\n1,2,3\n");
  const auto csv = CsvFile::open(folder / "results.csv", host::results_header());
  CHECK_FALSE(csv.has_value());
  STRCMP_CONTAINS("results.csv:1: another version's columns", csv.error().message.c_str());
}

TEST(ResultsTable, AFolderThatIsNotThereIsNamed) {
  STRCMP_CONTAINS("/nowhere/results.csv: No such file",
                  CsvFile::open("/nowhere/results.csv", host::results_header()).error().message.c_str());
}
